"""A small shot to try the engine on: four toy nodes in a folder of their own, run by processes that may be killed.

An evaluation may be held at a gate: it waits until the gate is opened, so that a fault strikes at a known moment.
"""

import json
import os
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

from hairpipe.engine.file.load import load_graph
from hairpipe.engine.plan.maintenance import items
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Store

FRAMES = 8
CHECKPOINT = 3
"""Number of frames of the sum after which its state is written: a kill loses no more."""
GRAPH = """schema = 1
frames = [1, {frames}]
fps = 24
[seed]
type = "make_seed"
[move]
type = "move_seed"
in.seed = "seed"
[sum]
type = "add_up"
in.number = "move"
checkpoint = {checkpoint}
[list]
type = "write_list"
in.numbers = "sum"
publish = "out/list.txt"
"""
TASKS = {"make_seed": "seed", "move_seed": "move", "add_up": "sum", "write_list": "list"}
"""Nodes of the graph by type."""
TALLY = "HAIRPIPE_BENCH_TALLY"
NODES = {
    "toy_value": """import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput


@dataclass(frozen=True)
class Number:
    value: np.ndarray


@dataclass(frozen=True)
class Total:
    value: np.ndarray


class Added(NamedTuple):
    number: Number
    state: Total


def tally(name, frame=None):
    path = Path(os.environ.get("HAIRPIPE_BENCH_TALLY", ""))
    if not path.name:
        raise BadInput("HAIRPIPE_BENCH_TALLY is not set")
    with path.open("a") as file:
        file.write(f"{name} {frame}\\n")
    gate = path.with_suffix(".gate")
    if gate.exists() and gate.read_text() == f"{name} {frame}":
        hold(gate)
    time.sleep(0.01)


def hold(gate):
    '''Wait at a gate, which holds one evaluation; the file `held` names process, parent and group.'''
    try:
        gate.rename(gate.with_suffix(".taken"))
    except FileNotFoundError:
        return
    gate.with_suffix(".new").write_text(f"{os.getpid()} {os.getppid()} {os.getpgid(0)}")
    gate.with_suffix(".new").rename(gate.with_suffix(".held"))
    end = time.monotonic() + 600.0
    while not gate.with_suffix(".open").exists() and time.monotonic() < end:
        time.sleep(0.02)
""",
    "make_seed": '''from toy_value import Number, np, tally

from hairpipe.engine import node


@node(frames="once")
def make_seed(*, value: float = 3.0) -> Number:
    """A number."""
    tally("make_seed")
    return Number(np.full(16, value))
''',
    "move_seed": '''from toy_value import Number, tally

from hairpipe.engine import Time, node


@node(frames="each")
def move_seed(seed: Number, time: Time) -> Number:
    """A number at each frame."""
    tally("move_seed", time.frame)
    return Number(seed.value + time.frame)
''',
    "add_up": '''from toy_value import Added, Number, Total, tally

from hairpipe.engine import Time, node


@node(frames="scan")
def add_up(number: Number, previous: Total | None, time: Time) -> Added:
    """Numbers added up over time."""
    tally("add_up", time.frame)
    total = number.value + (0.9 * previous.value if previous else 0.0)
    return Added(Number(2.0 * total), Total(total))
''',
    "write_list": '''from typing import Annotated

from toy_value import Number, tally

from hairpipe.engine import File, Frames, Workspace, node
from hairpipe.units import Suffixes


@node(frames="once")
def write_list(numbers: Frames[Number], workspace: Workspace) -> Annotated[File, Suffixes((".txt",))]:
    """A file of all numbers, and a companion file with their sum."""
    tally("write_list")
    values = [float(number.value[0]) for number in numbers.values()]
    (workspace / "list").write_text(repr(values))
    (workspace / "sum").write_text(repr(sum(values)))
    return File(workspace / "list", {"parts/sum.txt": workspace / "sum"})
''',
}
MAIN = "from hairpipe.graphs.experiments.bench.toy_shot import main; main()"

Results = dict[tuple[str, int | None], dict[str, str]]
"""Names of objects by node and frame, and by output."""


class ToyShot:
    """The shot in a folder: its graph file, its nodes, what it publishes."""

    def __init__(self, folder: Path, frames: int = FRAMES) -> None:
        self.folder = folder
        self.graph = folder / "shot.toml"
        self.out = folder / "out"
        nodes = folder / "nodes"
        nodes.mkdir(parents=True)
        self.graph.write_text(GRAPH.format(frames=frames, checkpoint=CHECKPOINT))
        for name, text in NODES.items():
            (nodes / f"{name}.py").write_text(text)
        self.variables = {TALLY: str(folder / "tally"), "HAIRPIPE_TRUST": str(nodes)}

    def start(self, store: Path, jobs: int = 2, place: Path | None = None) -> "subprocess.Popen[bytes]":
        """Start a run in a process, and a group, of its own; place is its current folder."""
        command = [sys.executable, "-P", "-c", MAIN, str(self.graph.absolute()), str(store.absolute()), str(jobs)]
        output = subprocess.PIPE
        environment = os.environ | self.variables
        return subprocess.Popen(
            command, stdout=output, stderr=output, env=environment, cwd=place, start_new_session=True
        )

    def finish(self, store: Path, jobs: int = 2) -> str:
        """Run it to its end; returns what went wrong, or nothing."""
        return fault_of(self.start(store, jobs))

    def published(self) -> dict[str, bytes]:
        """What it has published, by path."""
        paths = (path for path in self.out.rglob("*") if path.is_file())
        return {str(path.relative_to(self.out)): path.read_bytes() for path in paths}

    def close_gate(self, line: str) -> None:
        """Hold the first evaluation of this line of the tally."""
        self._gate.write_text(line)

    def held(self) -> tuple[int, int, int] | None:
        """Return the process that is held, its parent, and its group; None before there is one."""
        path = self._gate.with_suffix(".held")
        if not path.exists():
            return None
        child, parent, group = map(int, path.read_text().split())
        return child, parent, group

    def open_gate(self) -> None:
        """Let the evaluation go on."""
        self._gate.with_suffix(".open").touch()

    @property
    def _gate(self) -> Path:
        return Path(self.variables[TALLY]).with_suffix(".gate")

    def count(self) -> int:
        """Count the evaluations since the last call of `tally`."""
        path = Path(self.variables[TALLY])
        return path.read_bytes().count(b"\n") if path.exists() else 0

    def tally(self) -> list[tuple[str, int | None]]:
        """List evaluations, by node and frame, since the last call."""
        path = Path(self.variables[TALLY])
        lines = path.read_text().split("\n")[:-1] if path.exists() else []
        path.unlink(missing_ok=True)
        words = (line.split() for line in lines)
        return [(TASKS[name], None if frame == "None" else int(frame)) for name, frame in words]


def fault_of(process: "subprocess.Popen[bytes]") -> str:
    """Wait for a run; returns what went wrong, or nothing. A refusal is one line."""
    output, errors = process.communicate()
    if process.returncode == 0 and not errors:
        return ""
    failures = json.loads(output)["failures"] if output else []
    return "; ".join(failure["message"] for failure in failures) or errors.decode(errors="replace")[-300:]


def results(store: Path) -> Results:
    """Results of a store."""
    records = (item.record for item in items(Store(store, read_only=True)))
    return {(r.node, r.frame): {name: output.object for name, output in r.outputs.items()} for r in records}


def main() -> None:
    """Run the graph whose path, with store and number of jobs, is in the arguments; print the outcome as JSON."""
    graph, store, jobs = sys.argv[1:4]
    outcome = run(load_graph(Path(graph)), Store(Path(store)), options=Options(jobs=int(jobs)))
    print(json.dumps(asdict(outcome)))
    sys.exit(outcome.exit_code)
