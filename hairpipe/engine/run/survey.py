"""Progress of a shot, read from its store alone: results that exist, and results that any process computes now."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from hairpipe.engine.file.graph import Graph, origin
from hairpipe.engine.plan.key import Resolver
from hairpipe.engine.plan.scans import end_known_scan
from hairpipe.engine.plan.tasks import Task, is_beyond, sources
from hairpipe.engine.run.events import Judge, NodeProgress
from hairpipe.engine.store.digest import action_key
from hairpipe.engine.store.lease import FailureNote, Leases, recall_failure
from hairpipe.engine.store.store import Store

State = Literal["computed", "computing", "missing", "failed", "waiting", "diverged"]
"""State of a task.

failed    its latest evaluation failed, and no other one has started
waiting   an input does not exist yet, so that the key is unknown
diverged  the simulation diverged at this frame, or before
"""


@dataclass
class NodeSurvey(NodeProgress):
    """Progress of one node in a store: `width` and `running` are those of all processes, nothing is `cached`.

    total     number of results that can exist: without those after a divergence
    hosts     numbers of running tasks by machine
    failures  numbers of failed tasks by machine and message
    waiting   number of tasks without a key yet
    diverged  number of tasks that have no result since a simulation diverged
    """

    hosts: Counter[str] = field(default_factory=Counter)
    failures: Counter[FailureNote] = field(default_factory=Counter)
    waiting: int = 0
    diverged: int = 0

    @property
    def missing(self) -> int:
        """Number of tasks that could be computed now, and that no process computes."""
        return self.total - self.done - len(self.running) - self.failures.total() - self.waiting

    @property
    def work(self) -> float | None:
        """Time that one process needs for the rest [s]; None before the first result."""
        rate = 0.0 if self.done == self.total else self.seconds_per_frame
        return None if rate is None else rate * (self.total - self.done)

    @property
    def seconds_left(self) -> float | None:
        """Time that the rest takes at the recent rate [s]; None where no process computes this node."""
        return super().seconds_left if self.running else None


class Survey:
    """States of all results of a shot, for which other processes fill a store; `update` reads the changes.

    Nothing is computed or written. Results of stopped variants are left out. OSError where a store cannot be read.

    states    of the tasks, each after those it needs
    hosts     machines of the tasks that are computed now
    failures  of the tasks that failed
    """

    def __init__(self, graph: Graph, store: Store, frames: Iterable[int] | None, judge: Judge) -> None:
        read_only = Store(store.root, read_only=True)
        self._graph, self._judge = graph, judge
        self._resolver = Resolver(graph, read_only, graph.select(frames))
        self._leases = Leases(read_only)
        self._keys: dict[Task, str] = {}
        self._lost: frozenset[Task] = frozenset()
        self._limits: Mapping[str, int] = {}
        self.states: dict[Task, State] = {}
        self.hosts: dict[Task, str] = {}
        self.failures: dict[Task, FailureNote] = {}
        self.update()

    def update(self) -> None:
        """Read the store again, for tasks without a result; in place."""
        self.hosts, self.failures = {}, {}
        found: dict[Task, State] = {task: self._state_of(task) for task in self._resolver.tasks}
        kept = [task for task, state in found.items() if state == "computed" or not is_beyond(task, self._limits)]
        self.states = {task: found[task] for task in kept}

    def _state_of(self, task: Task) -> State:
        """Find the state of a task; those it needs have been found."""
        resolver = self._resolver
        if task in resolver.results:
            return "computed"
        if task in self._lost:
            return "diverged"
        if any(source.task not in resolver.results for source in sources(resolver.tasks[task])):
            return "waiting"
        if task not in self._keys:
            self._keys[task] = action_key(resolver.parts(task))
        key = self._keys[task]
        lease = self._leases.holder(key)  # before its result: it is given back after the result is stored
        record = resolver.find(task, key)
        if record is not None:
            resolver.results[task] = record
            self._limits = self._judge.limits(task, record)
            return "computed"
        divergence = end_known_scan(resolver, task, key)
        if divergence is not None:
            self._lost |= divergence.lost
            return "diverged"
        if lease is not None:
            self.hosts[task] = lease.host or "unknown"
            return "computing"
        failure = recall_failure(resolver.store, key)
        if failure is None:
            return "missing"
        self.failures[task] = failure
        return "failed"

    @property
    def complete(self) -> bool:
        """Whether all results exist, but those that a run does without after a divergence."""
        return all(state in ("computed", "diverged") for state in self.states.values())

    @property
    def seconds_left(self) -> float | None:
        """Time that the rest takes with as many processes as compute now [s]; frames of a simulation are not divided.

        None where no process computes, and before every node has a result.
        """
        nodes = self.nodes
        work = [node.work for node in nodes.values()]
        if not self.hosts or None in work:
            return None
        scans = {origin(node.name) for node in self._graph.nodes.values() if node.type.mode == "scan"}
        longest = max((nodes[name].seconds_left or 0.0 for name in scans), default=0.0)
        return max(longest, sum(filter(None, work)) / len(self.hosts))

    @property
    def nodes(self) -> dict[str, NodeSurvey]:
        """Progress by node of the graph file; the rate is the median of the latest results, by their time stamps."""
        nodes = {origin(name): NodeSurvey(0, 0) for name in self._graph.nodes}
        for task, state in self.states.items():
            node = nodes[origin(task.node)]
            node.total += state != "diverged"
            node.evaluated += state == "computed"
            node.waiting += state == "waiting"
            node.diverged += state == "diverged"
            if state == "computing":
                node.running.add(task)
                node.hosts[self.hosts[task]] += 1
            if state == "failed":
                node.failures[self.failures[task]] += 1
        for task, record in sorted(self._resolver.results.items(), key=lambda found: found[1].created):
            nodes[origin(task.node)].recent.append(record.seconds)
        for node in nodes.values():
            node.width = max(1, len(node.running))
        return nodes
