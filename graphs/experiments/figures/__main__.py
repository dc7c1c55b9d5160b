"""Start a command on recorded figures: `python -m hairpipe.graphs.experiments.figures NAME`."""

from hairpipe.cli.entry import start
from hairpipe.graphs.experiments.figures.commands import figures
from hairpipe.graphs.experiments.figures.file import PROGRAM

if __name__ == "__main__":
    start(figures, " ".join(PROGRAM))
