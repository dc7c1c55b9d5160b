"""One wedge computed in four ways: by a run, on a Dask cluster, as a job of a farm manager, by shuffled commands.

Each way has a copy of the graph file, a store, and a folder of published files.
"""

import json
import os
import random
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.machines.cluster import Cluster
from hairpipe.graphs.experiments.bench.machines.end_state import CheckValue, differences, state_of
from hairpipe.graphs.experiments.bench.machines.processes import Machine
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report

GRAPH = Path(__file__).resolve().parents[3] / "wedges" / "tuft.toml"
WEDGE, FRAMES = "sixteen", "1-24"
OPENJD = Path(sys.executable).parent / "openjd"
PROGRAM = """#!{python} -P
import os, subprocess, sys
words = [sys.executable, "-P", "-c", "from hairpipe.cli import main; main()", *sys.argv[1:]]
counts = os.environ.get("HAIRPIPE_BENCH_COUNTS") if sys.argv[1] == "run" else None
done = subprocess.run([*words, "-q", "--json"] if counts else words, stdout=subprocess.PIPE if counts else None)
if counts:
    with open(counts, "ab", buffering=0) as file:
        file.write(done.stdout.replace(b"\\n", b"") + b"\\n")
sys.exit(done.returncode)
"""
"""A program `hairpipe` that appends the summary of each run to a file, a line each."""


class Way:
    """A folder in which the wedge is computed in one way.

    graph, store, out  graph file, store and published files in it
    """

    def __init__(self, folder: Path, graph: Path) -> None:
        self.folder = folder
        self.graph = folder / "graphs" / "shots" / graph.name
        self.store = folder / "store"
        self.out = folder / "out"
        self._program = folder / "bin" / "hairpipe"
        self.graph.parent.mkdir(parents=True)
        self._program.parent.mkdir()
        shutil.copy(graph, self.graph)
        self._program.write_text(PROGRAM.format(python=sys.executable))
        self._program.chmod(0o755)

    @property
    def words(self) -> list[str]:
        """Words that name the shot after those of a command."""
        return [str(self.graph), "--wedge", WEDGE, "--frames", FRAMES, "--cache", str(self.store)]

    def call(self, words: list[str]) -> None:
        """Carry out a command, in which `hairpipe` is the program of this way; BadInput where it fails."""
        path = f"{self._program.parent}{os.pathsep}{os.environ['PATH']}"
        added = {"PATH": path, "HAIRPIPE_BENCH_COUNTS": str(self.folder / "counts")}
        place = str(self._program) if words[0] == "hairpipe" else words[0]
        done = subprocess.run([place, *words[1:]], capture_output=True, text=True, env=os.environ | added)
        if done.returncode:
            raise BadInput(
                f"exit code {done.returncode}: {(done.stderr or done.stdout)[-500:]}", where=shlex.join(words)
            )

    def runs(self) -> list[dict]:
        """Read the summaries of all runs."""
        return [json.loads(line) for line in (self.folder / "counts").read_text().splitlines()]


def run_here(way: Way) -> None:
    """Compute the wedge by one run."""
    way.call(["hairpipe", "run", *way.words, "-j", "2"])


def run_on_dask(way: Way) -> None:
    """Compute the wedge on a cluster of two machines with homes and kernels of their own."""
    cluster = Cluster(way.folder, [Machine(), Machine()], {})
    try:
        engine = ["--engine", "dask", "--scheduler", cluster.address, "--insecure"]
        way.call(["hairpipe", "run", *way.words, *engine])
    finally:
        cluster.close()


def run_as_job(way: Way) -> None:
    """Compute the wedge by a farm manager that carries out the tasks of all steps in order."""
    job = way.folder / "job"
    way.call(["hairpipe", "farm", *way.words, "-o", str(job)])
    last = json.loads((job / "job.json").read_text())["steps"][-1]["name"]
    parameters = ["-p", f"Graph={way.graph}", "-p", f"Cache={way.store}"]
    way.call([str(OPENJD), "run", str(job / "job.json"), "--step", last, "--run-dependencies", *parameters])


def run_shuffled(way: Way) -> None:
    """Compute the wedge by the commands of its tasks in a random order."""
    job = way.folder / "job"
    way.call(["hairpipe", "farm", *way.words, "--format", "commands", "-o", str(job)])
    text = (job / "commands.txt").read_text()
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    random.Random(0).shuffle(lines)
    for line in lines:
        way.call(shlex.split(line))


WAYS: Mapping[str, Callable[[Way], None]] = {
    "hairpipe run -j 2": run_here,
    "Dask, two machines": run_on_dask,
    "openjd run": run_as_job,
    "commands.txt, shuffled": run_shuffled,
}


def compare_ways(
    echo: Echo, check_value: CheckValue, graph: Path = GRAPH, ways: Mapping[str, Callable[[Way], None]] = WAYS
) -> Report:
    """Compute the wedge in every way and compare them with the first; BadInput where one fails, or openjd is absent."""
    if not OPENJD.exists():
        raise BadInput("openjd is not installed", right="pip install 'hairpipe[farm]'")
    cases: list[Case] = []
    states: list[dict[str, str]] = []
    counts: list[Counter[str]] = []
    with tempfile.TemporaryDirectory(prefix="hairpipe-parity-") as name:
        for number, (title, compute) in enumerate(ways.items()):
            echo(title)
            way = Way(Path(name).resolve() / f"way-{number}", graph)
            begun = time.perf_counter()
            compute(way)
            seconds = time.perf_counter() - begun
            runs = way.runs()
            states.append(state_of(way.store, way.out, check_value))
            counts.append(evaluations(runs))
            different = differences(states[-1], states[0]) + ["other counts"] * (counts[-1] != counts[0])
            published = sum(path.is_file() for path in way.out.rglob("*"))
            cases.append(
                {
                    "way": title,
                    "commands": len(runs),
                    "evaluated": counts[-1].total(),
                    "published files": published,
                    "seconds [s]": round(seconds, 1),
                    "results": states[-1]["results"][:12],
                    "violation": "; ".join(different),
                }
            )
    return make_report(__name__, {"ways": cases, "nodes": [{"node": n, "evaluated": c} for n, c in counts[0].items()]})


def evaluations(runs: list[dict]) -> Counter[str]:
    """Count the evaluations of some runs by node; pure."""
    found = Counter[str]()
    for run in runs:
        found.update({name: node["evaluated"] for name, node in run["nodes"].items() if node["evaluated"]})
    return found


def agree(report: Report) -> bool:
    """Whether all ways gave the same."""
    return not any(case["violation"] for case in report.tables["ways"])
