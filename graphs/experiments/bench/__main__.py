"""Start a bench: `python -m hairpipe.graphs.experiments.bench NAME`."""

from hairpipe.app.cli.entry import start
from hairpipe.graphs.experiments.bench.commands import PROGRAM, bench

if __name__ == "__main__":
    start(bench, " ".join(PROGRAM))
