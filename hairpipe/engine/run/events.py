"""The options of a run and what it reports: events, the progress counted from them, the outcome."""

import statistics
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from hairpipe.engine.file.graph import Graph, origin
from hairpipe.engine.hosts.host import Member
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.store.store import Record
from hairpipe.engine.worker.threading_layer import usable_cores

RECENT = 15
"""Number of latest evaluations whose median is the rate: the first ones include compilation."""

Kind = Literal["begun", "started", "finished", "cached", "failed", "warning", "published"]


class Judge:
    """Stops nodes while a graph is run: this base class stops none.

    judged  names of the nodes whose results decide; these are computed before the others
    """

    judged: frozenset[str] = frozenset()

    def limits(self, task: Task, record: Record) -> Mapping[str, int]:
        """Check a result; return the frames beyond which nodes are stopped, by name."""
        return {}


@dataclass(frozen=True)
class Options:
    """Options of a run; none of them changes a result.

    jobs          number of processes for values per frame, and of threads for those that simulate
    scans         number of simulations at a time on this machine, which share the threads
    keep_going    whether independent branches go on after a failure
    publish_root  folder below which files may be published, in addition to the graph's project
    force         whether files are replaced that were not published by hairpipe
    judge         stops nodes during the run
    only          frames to compute, of those of the run; None for all of them
    scheduler     address of a Dask scheduler whose workers evaluate; None for this machine
    insecure      whether a connection to it without TLS is allowed
    wait          time for which the run waits for results that only other processes evaluate [s]; None without end
    spare         idle workers that stay between runs of which each is given this list; None: they end with the run
    """

    jobs: int = field(default_factory=usable_cores)
    keep_going: bool = False
    publish_root: Path | None = None
    force: bool = False
    only: tuple[int, ...] | None = None
    scheduler: str | None = None
    insecure: bool = False
    wait: float | None = None
    judge: Judge = Judge()  # noqa: RUF009 (it has no state)
    spare: list[Member] | None = None
    scans: int = 1


@dataclass(frozen=True)
class Event:
    """Something that happened to a task.

    kind     begun: totals are known; started and finished: an evaluation; cached: its result is in the store; failed;
             warning: of a node, repeated where its result is cached; published: a file was written
    seconds  that the evaluation took, of `finished` and of `cached` [s]
    message  of a failure, a warning, or the path that was published
    totals   number of tasks by node, of `begun`
    record   of the result, of `finished` and of `cached`
    parts    of a failure
    """

    kind: Kind
    task: Task | None = None
    seconds: float = 0.0
    message: str = ""
    totals: tuple[tuple[str, int], ...] = ()
    record: Record | None = None
    parts: Mapping[str, str | None] = field(default_factory=dict)

    def __str__(self) -> str:
        """One line: `hair@12: finished in 1.3 s`."""
        what = f"begun: {sum(count for _, count in self.totals):,} results" if self.kind == "begun" else self.kind
        took = f" in {self.seconds:.2g} s" if self.kind == "finished" else ""
        return f"{f'{self.task}: ' if self.task else ''}{what}{took}{f': {self.message}' if self.message else ''}"


Report = Callable[[Event], None]


@dataclass(frozen=True)
class Failure:
    """A task without a result.

    kind       input: something the user can fix; node: it raised; diverged: it raised ArithmeticError itself, not a
               subclass; disk: full; crash: its process died; gone: its machine did not answer; mismatch: no machine has
               the code, versions and files of its key; publish
    traceback  of the node, for those who wrote it
    parts      what, where and right of a BadInput of the node; empty for another failure
    """

    task: Task
    kind: Literal["input", "node", "diverged", "disk", "crash", "gone", "mismatch", "publish"]
    message: str
    traceback: str = ""
    parts: Mapping[str, str | None] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.task}: {self.message}"


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    evaluated  number of evaluations; cached number of results that were there; blocked number of results that were
               asked for and not reached, leased number of those that another process was evaluating at the end
    seconds    of evaluation by node of the graph file, those of cached results not counted [s]
    processor  processor seconds of all its threads and children, by node [s]
    compiled   seconds of evaluation in which kernels were compiled, by node [s]
    """

    evaluated: int
    cached: int
    blocked: int
    failures: tuple[Failure, ...]
    published: tuple[str, ...]
    seconds: dict[str, float]
    processor: dict[str, float]
    interrupted: bool
    leased: int = 0
    compiled: dict[str, float] = field(default_factory=dict)

    @property
    def exit_code(self) -> int:
        """0 complete, 1 not complete, 2 all failures are input that the user can fix, 75 leased, 130 interrupted."""
        if self.interrupted:
            return 130
        if not self.failures:
            return 75 if self.leased else 1 if self.blocked else 0
        return 2 if all(failure.kind in ("input", "mismatch") for failure in self.failures) else 1


@dataclass
class NodeProgress:
    """Progress of one node.

    width  number of its frames that are evaluated at once
    """

    total: int
    width: int
    cached: int = 0
    evaluated: int = 0
    running: set[Task] = field(default_factory=set)
    recent: deque[float] = field(default_factory=lambda: deque(maxlen=RECENT))

    @property
    def done(self) -> int:
        """Number of established tasks; one that was evaluated again counts once."""
        return min(self.total, self.cached + self.evaluated)

    @property
    def seconds_per_frame(self) -> float | None:
        """Median of the recent evaluations [s]; None before the first."""
        return statistics.median(self.recent) if self.recent else None

    @property
    def seconds_left(self) -> float | None:
        """Time that the rest takes at the recent rate [s]; None before the first evaluation."""
        rate = self.seconds_per_frame
        return None if rate is None else rate * (self.total - self.done) / self.width


class Progress:
    """Progress of all nodes of a run, by their names in the graph file; `update` it with every event.

    jobs  of the run
    """

    def __init__(self, graph: Graph, jobs: int) -> None:
        modes = {origin(node.name): node.type.mode for node in graph.nodes.values()}
        self._widths = {name: jobs if mode == "each" else 1 for name, mode in modes.items()}
        self.nodes: dict[str, NodeProgress] = {}

    def update(self, event: Event) -> None:
        if event.kind == "begun":
            self.nodes = {name: NodeProgress(total, self._widths[name]) for name, total in event.totals}
        if event.task is None:
            return
        node = self.nodes[origin(event.task.node)]
        if event.kind == "started":
            node.running.add(event.task)
        elif event.kind in ("finished", "failed", "cached"):
            node.running.discard(event.task)
        node.cached += event.kind == "cached"
        node.evaluated += event.kind == "finished"
        if event.kind == "finished":
            node.recent.append(event.seconds)
