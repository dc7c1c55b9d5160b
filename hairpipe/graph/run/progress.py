"""How far a run is, node by node: counted from its events, drawn by somebody else."""

import statistics
from collections import deque
from dataclasses import dataclass, field

from hairpipe.graph.file.graph import Graph
from hairpipe.graph.plan.tasks import Task
from hairpipe.graph.run.events import Event

RECENT = 15
"""Evaluations whose median is the rate: the first ones compile, the last ones tell how it goes now."""


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
        """Tasks that are established; what had to be evaluated again counts once."""
        return min(self.total, self.cached + self.evaluated)

    @property
    def seconds_per_frame(self) -> float | None:
        """Median of the recent evaluations [s]; None before the first."""
        return statistics.median(self.recent) if self.recent else None

    @property
    def seconds_left(self) -> float | None:
        """Time that the rest takes at the recent rate [s]; None where nothing is known."""
        rate = self.seconds_per_frame
        return None if rate is None else rate * (self.total - self.done) / self.width


class Progress:
    """Progress of all nodes of a run, by name; feed it every event.

    jobs  of the run
    """

    def __init__(self, graph: Graph, jobs: int) -> None:
        self._widths = {node.name: jobs if node.type.mode == "each" else 1 for node in graph.nodes.values()}
        self.nodes: dict[str, NodeProgress] = {}

    def update(self, event: Event) -> None:
        """Take an event in."""
        if event.kind == "begun":
            self.nodes = {name: NodeProgress(total, self._widths[name]) for name, total in event.totals}
        if event.task is None:
            return
        node = self.nodes[event.task.node]
        if event.kind == "started":
            node.running.add(event.task)
        elif event.kind in ("finished", "failed", "cached"):
            node.running.discard(event.task)
        node.cached += event.kind == "cached"
        node.evaluated += event.kind == "finished"
        if event.kind == "finished":
            node.recent.append(event.seconds)
