"""Scans: which of their states are kept, and what becomes of their consumers where they diverge.

The state of a running scan stays in the memory of a worker, which writes that of every n-th frame, a checkpoint, and in
between one after every 30 s of evaluations. Of those in between the last two are kept, the last but one in case the
last is damaged: all states of a shot may exceed the disk space. If another scan of the run can have the same first
frames, as variants of a wedge do, a state is written, and kept until that scan has reached it or differs: otherwise it
would recompute the shared frames.

Where a scan diverges, nodes with `Reached` inputs continue with the frames before.
"""

from collections import Counter, defaultdict
from functools import cached_property
from typing import NamedTuple

from hairpipe.engine.file.graph import Node
from hairpipe.engine.plan.key import Resolver
from hairpipe.engine.plan.tasks import Task, sources
from hairpipe.engine.store.digest import action_key, canonical, digest
from hairpipe.engine.store.store import Record


class Thinner:
    """Chooses states to write, and removes obsolete ones; an object that a record uses in another role is kept.

    Each state is checked once after its frame, and again only if its frame was evaluated again.
    """

    def __init__(self, resolver: Resolver) -> None:
        self.resolver = resolver
        self._roles: Counter[str] = Counter()
        self._passed: set[Task] = set()
        self._next: dict[str, int] = {}
        self._reached: dict[str, int] = {}
        self._behind: dict[str, int] = {}
        self._written: dict[str, int] = {}
        self._parted: set[tuple[str, str]] = set()

    def add(self, task: Task, record: Record, before: Record | None) -> None:
        """Count the roles of the objects of a result, in place of those of the previous result of its task."""
        if before is not None:
            self._roles.subtract(objects_besides_state(before))
            self._roles.subtract([] if task in self._passed else state_objects(before))
        self._passed.discard(task)
        self._roles.update(objects_besides_state(record))
        self._roles.update(state_objects(record))
        if task.frame is not None:
            self._next[task.node] = min(self._next.get(task.node, task.frame), task.frame)
            self._reached[task.node] = max(self._reached.get(task.node, task.frame), task.frame)

    def must_write(self, task: Task) -> bool:
        """Whether the state of a scan is written at a task in any case."""
        node = self.resolver.graph.nodes[task.node]
        return (
            task in self.resolver.demanded
            or task.frame is None
            or self.resolver.thinnable(node) is None
            or is_checkpoint(node, task, self.resolver.graph.begin)
            or self._is_awaited(task.node, task.frame)
        )

    def thin_behind(self, task: Task) -> None:
        """Remove states before the last two written ones of the scan of a task, and states kept for this scan."""
        if task.frame is not None:
            self._behind[task.node] = min(self._written.get(task.node, task.frame - 1), task.frame)
            self._written[task.node] = task.frame
            for name in (task.node, *self._twins.get(task.node, ())):
                end = self._behind.get(name, self.resolver.graph.begin)
                frames = range(self._next.get(name, end), end)
                self._thin_before(name, next((frame for frame in frames if self._is_awaited(name, frame)), end))

    def thin_all(self) -> None:
        """Remove all states but the last of complete scans."""
        last = {task.node: task.frame for task in self.resolver.tasks}
        lacking = {task.node for task in self.resolver.tasks.keys() - self.resolver.results.keys()}
        for node, frame in last.items():
            if frame is not None and node not in lacking:
                self._thin_before(node, frame)

    def _thin_before(self, name: str, end: int) -> None:
        """Remove the states of a scan before a frame."""
        node = self.resolver.graph.nodes[name]
        store = self.resolver.store
        if self.resolver.thinnable(node) is None:
            return
        begin = self._next.get(name, end)
        self._next[name] = max(begin, end)
        for task in (Task(name, frame) for frame in range(begin, end)):
            record = self.resolver.results.get(task)
            if record is None or task in self._passed or is_checkpoint(node, task, self.resolver.graph.begin):
                continue
            self._passed.add(task)
            for spared in state_objects(record):
                self._roles[spared] -= 1
                if self._roles[spared] <= 0 and store.has(spared) and spared not in self._held_before:
                    store.remove(store.object_path(spared))

    def _is_awaited(self, name: str, frame: int) -> bool:
        """Whether another scan can still reach the state of this scan at a frame."""
        return any(self._may_share(name, twin, frame) for twin in self._twins.get(name, ()))

    def _may_share(self, name: str, twin: str, frame: int) -> bool:
        """Whether a scan can equal another up to a frame that it has not reached yet."""
        results = self.resolver.results
        ahead = self._reached.get(twin, self.resolver.graph.begin - 1)
        if (name, twin) in self._parted or ahead >= frame:
            return False
        own = Task(name, ahead)
        other = Task(twin, ahead)
        following = Task(twin, ahead + 1)
        same = own not in results or other not in results or results[own].key == results[other].key
        if same and following in self.resolver.tasks:
            known = all(source.task in results for source in sources(self.resolver.tasks[following]))
            same = not known or action_key(self.resolver.parts(following)) == self._key_of(Task(name, ahead + 1))
        if not same:
            self._parted.add((name, twin))
        return same

    def _key_of(self, task: Task) -> str:
        record = self.resolver.results.get(task)
        return action_key(self.resolver.parts(task)) if record is None else record.key

    @cached_property
    def _twins(self) -> dict[str, tuple[str, ...]]:
        """Scans of the same type and settings, by scan: only these can have equal frames."""
        alike: defaultdict[str, list[str]] = defaultdict(list)
        for node in self.resolver.graph.nodes.values():
            if node.type.mode == "scan":
                alike[canonical([node.type.name, node.settings])].append(node.name)
        return {name: tuple(n for n in names if n != name) for names in alike.values() for name in names}

    @cached_property
    def _held_before(self) -> set[str]:
        """Objects in the records of the store that are not states of scans."""
        records = map(self.resolver.store.record, self.resolver.store.record_keys())
        return {name for record in records if record is not None for name in objects_besides_state(record)}


def is_checkpoint(node: Node, task: Task, first: int) -> bool:
    """Whether a frame is a checkpoint, counted from the first frame of a scan."""
    return task.frame is not None and (task.frame - first + 1) % node.checkpoint == 0


def objects_besides_state(record: Record) -> set[str]:
    return {name for name, _ in record.objects(without=record.state)}


def state_objects(record: Record) -> list[str]:
    """Return the object of the state of a scan, if a record has one."""
    return [] if record.state is None else [record.outputs[record.state].object]


class Divergence(NamedTuple):
    """A scan that diverged."""

    lost: frozenset[Task]  # tasks of the scan, from the failed one on
    consumers: frozenset[Task]  # tasks of other nodes that continue with the frames before


def divergence_note(key: str) -> str:
    """Return the name of the note in the store on divergence of the task with this key; plans read it."""
    return digest("ending", key)


def end_known_scan(resolver: Resolver, task: Task, key: str) -> Divergence | None:
    """End a scan, as `end_scan`, if the store has a note on divergence of the task with this key."""
    return None if resolver.store.recall(divergence_note(key)) is None else end_scan(resolver, task)


def end_scan(resolver: Resolver, failed: Task) -> Divergence | None:
    """Remove the tasks of a scan, from a failed one on, from `Reached` inputs; in place.

    Returns None without a change if another node needs all frames, no node needs any, or no frame was reached.
    """
    node = resolver.graph.nodes[failed.node]
    if node.type.mode != "scan" or node.publish is not None or failed.frame is None:
        return None
    tasks = [task for task in resolver.tasks if task.node == failed.node]
    lost = frozenset(task for task in tasks if task.frame is not None and task.frame >= failed.frame)
    left = {}
    for task, inputs in resolver.tasks.items():
        socket = resolver.graph.nodes[task.node].type.socket
        for plug, found in inputs.items():
            if task.node == failed.node or not any(source.task in lost for source in found):
                continue
            left[task, plug] = [source for source in found if source.task not in lost]
            if socket(plug).view != "reached" or not left[task, plug]:
                return None
    for (task, plug), found in left.items():
        resolver.tasks[task][plug] = found
    return Divergence(lost, frozenset(task for task, _ in left)) if left else None
