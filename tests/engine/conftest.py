"""A shot to try the engine on: toy nodes beside a graph file, and a count of what was evaluated."""

import json
import os
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from hairpipe.engine.code import CodeReader
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.hosts.host import Host, Job, LocalEngine, Member, Slots
from hairpipe.engine.hosts.offer import Offer
from hairpipe.engine.plan.planner import plan, read_result
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.run import scheduler
from hairpipe.engine.run.events import Event, Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Store
from hairpipe.engine.worker import machine_code

HERE = Path(__file__).parent

HEAD = """schema = 1
frames = [{first}, {last}]
fps = 24
[seed]
type = "make_seed"
value = 3
[move]
type = "move_seed"
in.seed = "seed"
"""
CHAIN = (
    HEAD
    + """
[sum]
type = "add_up"
in.number = "move"
checkpoint = 4
[list]
type = "write_list"
in.numbers = "sum"
publish = "out/list.txt"
"""
)


PATIENCE = 240.0
"""Seconds after which a process that does not answer has failed: before the test itself is stopped."""


def wait_for(condition: Callable[[], bool]) -> None:
    """Wait until a condition holds; AssertionError where it does not in time."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def local_engine(shot, spare=None, sources=None) -> LocalEngine:
    """Make an engine for a shot, with further sources that its workers are told of."""
    reader = CodeReader(shot.store.remember)
    reader.stamps |= sources or {}
    offer = Offer(str(shot.store.root), str(shot.nodes), ())
    return LocalEngine(Host(offer, "here", 1, reader, {"none": "code"}, spare))


class Machines:
    """An engine of two machines on this one, `a` and `b`.

    refuse   machines whose jobs have another digest of the code
    in_turn  whether jobs of scans go to one machine after the other, as if the one before had no free slot
    """

    def __init__(self, resolver, refuse=(), in_turn=False) -> None:
        self.engines = {}
        for name in "ab":
            offer = Offer(str(resolver.store.root), str(resolver.graph.folder), ())
            reader = CodeReader(resolver.store.remember, resolver.graph.folder)
            self.engines[name] = LocalEngine(Host(offer, name, 1, reader))
        self.machines, self.warnings, self.refuse, self.in_turn = set("ab"), [], refuse, in_turn
        self.order, self.given, self.replied = "ab", Counter(), Counter()

    def slots(self) -> Slots:
        free = [engine.slots() for name, engine in self.engines.items() if name in self.machines]
        return Slots(*map(min if self.in_turn else sum, zip(*free, strict=True)))

    def submit(self, job: Job) -> None:
        if self.in_turn:
            self.order = self.order[::-1] if job.wide else self.order
            machine = self.order[0]
        else:
            able = [name for name in sorted(self.machines) if self.engines[name].slots()[not job.wide]]
            machine = next((name for name in able if name not in job.avoid), able[0])
        self.given[machine] += 1
        wrong = {"code": "0" * 40} if machine in self.refuse else {}
        self.engines[machine].submit(replace(job, parts=job.parts | wrong))

    def replies(self, timeout: float | None) -> Iterator:
        engines = self.engines.values()
        while not (found := [reply for engine in engines for reply in engine.replies(0.02)]) and timeout is None:
            pass
        self.replied.update((reply["machine"], "leased" in reply) for reply in found)
        yield from found

    def leave_out(self, machine: str) -> None:
        self.machines.discard(machine)

    def cancel(self, keys) -> None:
        for engine in self.engines.values():
            engine.cancel(keys)

    def close(self) -> None:
        for engine in self.engines.values():
            engine.close()


@pytest.fixture
def machines(monkeypatch) -> Callable[..., list[Machines]]:
    """Let runs use two machines, of these settings; gives the engines of all runs."""

    def use(**settings) -> list[Machines]:
        made = []
        engine = lambda resolver, options: made.append(Machines(resolver, **settings)) or made[-1]  # noqa: E731
        monkeypatch.setattr(scheduler, "make_engine", engine)
        return made

    return use


NO_PARTS = {"code": "code", "settings": {}, "inputs": {}}
NO_JOB = Job("0" * 40, "a", None, "no_such_type", "none", NO_PARTS, {}, {}, {}, (), None, False)
"""A job that fails."""


class Shot:
    """A graph file in a folder of its own, and its store."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.path = folder / "shot.toml"
        self.nodes = folder / "nodes"
        self.store = Store(folder / "cache")
        self.spare: list[Member] | None = None
        shutil.copytree(HERE / "toys", self.nodes, ignore=shutil.ignore_patterns("__pycache__"))
        self.write(CHAIN)

    def write(self, text: str, first: int = 1, last: int = 10) -> None:
        """Write the graph file."""
        self.path.write_text(text.replace("{first}", str(first)).replace("{last}", str(last)))

    def add(self, text: str) -> None:
        """Add nodes to the graph file."""
        self.path.write_text(self.path.read_text() + text)

    def change(self, old: str, new: str) -> None:
        """Change the graph file."""
        self.edit(f"../{self.path.name}", old, new)

    def edit(self, file: str, old: str, new: str) -> None:
        """Change a file of nodes."""
        path = self.nodes / file
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))

    def load(self, **settings):
        """Load the graph afresh, as a new process would."""
        for name in [path.stem for path in self.nodes.glob("*.py")]:
            sys.modules.pop(name, None)
        return load_graph(self.path, {name.replace("__", "."): str(value) for name, value in settings.items()})

    def run(
        self,
        frames=None,
        *,
        to=(),
        store=None,
        report=lambda event: None,
        jobs=1,
        keep_going=False,
        root=None,
        force=False,
        **settings,
    ):
        """Run the graph; returns the outcome. `warned` has tasks and messages of its warnings."""
        graph = self.load(**settings)
        graph = graph.upto(to) if to else graph
        options = Options(jobs=jobs, keep_going=keep_going, publish_root=root, force=force, spare=self.spare)
        self.warned = []

        def listen(event: Event) -> None:
            self.warned += [(str(event.task), event.message)] if event.kind == "warning" else []
            report(event)

        return run(graph, store or self.store, frames, options, listen)

    def value(self, name: str, output: str = ""):
        """Read a result, such as `sum@3`."""
        node, _, frame = name.partition("@")
        return read_result(self.load(), self.store, Task(node, int(frame) if frame else None), output).value

    def plan(self, frames=None, **settings):
        """Plan the graph; returns entries by name of the task."""
        return {str(entry.task): entry for entry in plan(self.load(**settings), self.store, frames)}

    def tally(self) -> Counter:
        """Count evaluations by node type since the last call."""
        path = Path(os.environ["TOY_TALLY"])
        lines = path.read_text().splitlines() if path.exists() else []
        path.unlink(missing_ok=True)
        return Counter(line.split()[0] for line in lines)

    def has_called(self, line: str) -> bool:
        """Whether an evaluation has been noted: a node type and a frame."""
        path = Path(os.environ["TOY_TALLY"])
        return path.exists() and line in path.read_text()

    def results(self, store=None, **settings) -> dict[str, dict[str, str]]:
        """Objects of all results, by task and output; everything has to be there."""
        from hairpipe.engine.plan.key import Resolver
        from hairpipe.engine.store.digest import action_key

        graph = self.load(**settings)
        resolver = Resolver(graph, store or self.store, graph.select(None))
        for task in resolver.tasks:
            resolver.results[task] = resolver.find(task, action_key(resolver.parts(task)))
        return {str(t): {n: o.object for n, o in r.outputs.items()} for t, r in resolver.results.items()}

    def start(self, store=None, jobs=2, **environment) -> subprocess.Popen:
        """Start a run in a process of its own."""
        command = [sys.executable, HERE / "drive.py", self.path, (store or self.store).root, str(jobs)]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=os.environ | environment)

    @staticmethod
    def outcome(process: subprocess.Popen) -> dict:
        """Wait for a run of its own and read its outcome."""
        output, errors = process.communicate(timeout=PATIENCE)
        assert output, errors.decode()
        return json.loads(output)


@pytest.fixture(autouse=True)
def trusted(tmp_path, monkeypatch) -> None:
    """The nodes of tests are trusted, whatever a test makes of them."""
    monkeypatch.setenv("HAIRPIPE_TRUST", str(tmp_path / "nodes"))


@pytest.fixture
def shot(tmp_path, monkeypatch) -> Shot:
    """A shot of ten frames: seed -> move -> sum (a scan) -> list (a file)."""
    monkeypatch.setenv("TOY_TALLY", str(tmp_path / "tally"))
    # Toys call no kernel of ours: a new store would analyse all modules that hold some, at half the cost of a run.
    monkeypatch.setattr(machine_code, "kernel_modules", lambda: iter(()))
    monkeypatch.setattr(sys, "path", list(sys.path))
    before = set(sys.modules)
    yield Shot(tmp_path)
    for name in set(sys.modules) - before:
        if str(tmp_path) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


@pytest.fixture(scope="session")
def known() -> dict:
    """What runs give that nobody disturbs, once there was one."""
    return {}


@pytest.fixture
def undisturbed(shot, known) -> dict:
    """Results, published text and counts of evaluations of the shot, by a run that nobody disturbs."""
    if "results" not in known:
        store, published = Store(shot.folder / "undisturbed"), shot.folder / "out" / "list.txt"
        assert shot.run(store=store).exit_code == 0
        known |= {"results": shot.results(store), "text": published.read_text(), "tally": shot.tally()}
        published.unlink()
    return known


@pytest.fixture
def kept(shot) -> None:
    """Let the runs of the shot keep their workers for each other: each start takes half a second."""
    shot.spare = []
    yield
    for member in shot.spare:
        member.end()
