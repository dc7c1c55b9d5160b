"""A shot of nearly empty nodes, run in a new process to measure the engine."""

import json
import os
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from hairpipe.child import command, environment
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.file.trust import VARIABLE
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput

EACH, SCAN = "moved", "total"
"""Names of the nodes with one result per frame; both depend on one result for the shot."""
GRAPH = f"""schema = 1
frames = [1, {{frames}}]
fps = 24
seed.type = "toy_seed"
{EACH} = {{{{ type = "toy_each", in.seed = "seed" }}}}
{SCAN} = {{{{ type = "toy_scan", in.seed = "seed" }}}}
"""
HEAD = "from toy_value import Number, np\nfrom hairpipe.engine import Time, node\n"
NODES = {
    "toy_value": """from dataclasses import dataclass
import numpy as np
@dataclass(frozen=True)
class Number:
    value: np.ndarray
""",
    "toy_seed": HEAD
    + """@node(frames="once")
def toy_seed() -> Number:
    '''Sixteen numbers.'''
    return Number(np.full(16, 3.0))
""",
    "toy_each": HEAD
    + """@node(frames="each")
def toy_each(seed: Number, time: Time) -> Number:
    '''Numbers of a frame.'''
    return Number(seed.value + time.frame)
""",
    "toy_scan": HEAD
    + """@node(frames="scan")
def toy_scan(seed: Number, previous: Number | None) -> Number:
    '''A running sum.'''
    return Number(seed.value + (previous.value if previous else 0.0))
""",
}
_BOOT = f"from {__name__} import report_run; report_run({{!r}}, {{!r}}, {{!r}}, {{!r}}, {{!r}})"


class ToyRun(NamedTuple):
    """Cost of a run.

    run      time from reading the graph to the last result [s]
    process  the same with the start of Python and imports [s]
    memory   peak memory of the coordinator [MB]; None if the system does not measure it
    """

    evaluated: int
    cached: int
    run: float
    process: float
    memory: float | None


class ToyShot(NamedTuple):
    """The shot, in a folder with a store."""

    folder: Path

    def run(self, nodes: tuple[str, ...], jobs: int, scheduler: str | None = None) -> ToyRun:
        """Run the shot up to these nodes in a new process; BadInput if the run fails.

        scheduler  address of the Dask scheduler; None for the engine of this machine
        """
        code = _BOOT.format(str(self.folder / "shot.toml"), str(self.folder / "store"), nodes, jobs, scheduler)
        variables = environment() | {VARIABLE: str(self.folder / "nodes")}
        begun = time.perf_counter()
        done = subprocess.run(command(code), env=variables, stdout=subprocess.PIPE)
        process = time.perf_counter() - begun
        if done.returncode:
            raise BadInput("the run of toy nodes failed", where=scheduler, right="the messages above to be fixed")
        return ToyRun(process=process, **json.loads(done.stdout))


@contextmanager
def toy_shot(frames: int) -> Iterator[ToyShot]:
    """Write a shot in a temporary folder with an empty store."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        (folder / "shot.toml").write_text(GRAPH.format(frames=frames))
        (folder / "nodes").mkdir()
        for node, text in NODES.items():
            (folder / "nodes" / f"{node}.py").write_text(text)
        yield ToyShot(folder)


def report_run(graph_path: str, store: str, nodes: tuple[str, ...], jobs: int, scheduler: str | None) -> None:
    """Run a graph in this process, and print its cost as JSON."""
    begun = time.perf_counter()
    graph = load_graph(Path(graph_path)).upto(nodes)
    outcome = run(graph, Store(Path(store)), options=Options(jobs=jobs, scheduler=scheduler, insecure=True))
    seconds = time.perf_counter() - begun
    for failure in outcome.failures:
        os.write(2, f"{failure.message}\n".encode())
    if outcome.exit_code:
        raise SystemExit(outcome.exit_code)
    counts = {"evaluated": outcome.evaluated, "cached": outcome.cached}
    os.write(1, json.dumps(counts | {"run": seconds, "memory": peak_memory()}).encode())


def peak_memory() -> float | None:
    """Return the peak memory of this process [MB]; `getrusage` would include its parent before `exec`."""
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    except OSError:
        return None
    return next(1024e-6 * int(line.split()[1]) for line in lines if line.startswith("VmHWM:"))
