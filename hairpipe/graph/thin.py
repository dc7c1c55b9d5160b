"""Thins the states of scans: what is needed to go on from somewhere, not from everywhere.

While a scan runs the states of its last two frames are there, and that of every n-th: a shot need not fit on the disk
with all its states. The last but one is there for the case that the last is found damaged.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cached_property

from hairpipe.graph.graph import Node
from hairpipe.graph.record import Record, read_record
from hairpipe.graph.resolve import Resolver
from hairpipe.graph.store import Store
from hairpipe.graph.tasks import Task


class Thinner:
    """Removes the states that a run has left behind; an object that some record holds in another role stays."""

    def __init__(self, resolver: Resolver) -> None:
        self.resolver = resolver

    def follow(self, task: Task) -> None:
        """Let go of the states before the last two of a scan that has been evaluated at a task."""
        if self.resolver.thinnable(self.resolver.graph.nodes[task.node]) is not None:
            self._thin(lambda other: other.node == task.node and _frame(other) < _frame(task) - 1)

    def finish(self) -> None:
        """Let go of all states but the last of scans that are complete."""
        last = {task.node: task for task in self.resolver.tasks}
        lacking = {task.node for task in self.resolver.tasks.keys() - self.resolver.results.keys()}
        self._thin(lambda task: task.node not in lacking and task != last[task.node])

    def _thin(self, passed: Callable[[Task], bool]) -> None:
        kept: set[str] = set()
        spare: set[str] = set()
        for task, record in self.resolver.results.items():
            node = self.resolver.graph.nodes[task.node]
            if record.state is not None:
                may_go = self.resolver.thinnable(node) is not None and passed(task)
                goes = may_go and not is_checkpoint(node, task, self.resolver.graph.begin)
                (spare if goes else kept).add(record.outputs[record.state].object)
        spare = {name for name in spare - kept if self.resolver.store.has(name)}
        if spare:
            held = self._held_before.union(*map(others, self.resolver.results.values()))
            for name in spare - held:
                self.resolver.store.remove(self.resolver.store.object_path(name))

    @cached_property
    def _held_before(self) -> set[str]:
        return set(held(self.resolver.store))


def _frame(task: Task) -> int:
    """Frame of a task of a scan."""
    assert task.frame is not None
    return task.frame


def is_checkpoint(node: Node, task: Task, first: int) -> bool:
    """Whether a frame is an n-th one, counted from the first of a scan."""
    return task.frame is not None and (task.frame - first + 1) % node.checkpoint == 0


def others(record: Record) -> set[str]:
    """Name the objects that a record holds other than as the state of a scan."""
    return {name for name, _ in record.objects(without=record.state)}


def held(store: Store) -> Iterator[str]:
    """Name the objects that any record of the store holds so."""
    for path in (store.root / "actions").glob("??/*.json"):
        with suppress(FileNotFoundError):  # cleaned away by another process
            record = read_record(path.read_text(encoding="utf-8", errors="replace"))
            if record:
                yield from others(record)
