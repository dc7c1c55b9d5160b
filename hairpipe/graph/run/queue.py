"""Tasks that could be evaluated now, and which of them a free worker takes first."""

import heapq
from collections.abc import Iterator

from hairpipe.graph.file.graph import Graph
from hairpipe.graph.plan.tasks import Task, order_of
from hairpipe.graph.run.pool import Lane


class Queue:
    """Ready tasks by mode, each in the order of frames: what a scan waits for does not fall behind.

    The wide worker takes scans, the critical path, then values for the shot; narrow ones take values per frame, and
    help with values for the shot while the wide one is busy.
    """

    def __init__(self, graph: Graph) -> None:
        self._mode = {node.name: node.type.mode for node in graph.nodes.values()}
        self._order = order_of(graph)
        self._heaps: dict[str, list[tuple[int, int, Task]]] = {"scan": [], "once": [], "each": []}

    def __len__(self) -> int:
        """Count the ready tasks."""
        return sum(len(heap) for heap in self._heaps.values())

    def push(self, task: Task) -> None:
        """Add a task."""
        rank, frame = self._order(task)
        heapq.heappush(self._heaps[self._mode[task.node]], (frame, rank, task))

    def take(self, lane: Lane, *, wide_is_free: bool) -> Iterator[Task]:
        """Take tasks for this lane, best first, as long as the caller asks for another."""
        modes = ("scan", "once") if lane == "wide" else ("each",) if wide_is_free else ("each", "once")
        for mode in modes:
            while self._heaps[mode]:
                yield heapq.heappop(self._heaps[mode])[2]
