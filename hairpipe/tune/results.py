"""What the store holds of a graph after a run: values, and how long they took."""

from collections.abc import Iterable
from typing import Any

from hairpipe.graph.file.graph import Graph
from hairpipe.graph.plan.planner import plan
from hairpipe.graph.plan.tasks import Task, at
from hairpipe.graph.run.events import CODEC
from hairpipe.graph.store.record import Record
from hairpipe.graph.store.store import Store
from hairpipe.graph.store.values import Values, codec_named


class Results:
    """The results of a graph at these frames."""

    def __init__(self, graph: Graph, store: Store, frames: Iterable[int]) -> None:
        self._graph, self._store = graph, store
        self._keys = {entry.task: entry.key for entry in plan(graph, store, frames) if entry.status == "cached"}

    def record(self, task: Task) -> Record:
        """Give the record of a task; KeyError where it was not computed."""
        record = self._store.record(self._keys[task] or "")
        if record is None:
            raise KeyError(task)
        return record

    def value(self, name: str) -> Any:
        """Read the value of a node for the shot, of one output."""
        output, kind = next(iter(self._graph.nodes[name].type.outputs.items()))
        values = Values(self._store, codec_named(CODEC), 0)
        return values.get(self.record(Task(name, None)).outputs[output].object, kind)

    def seconds(self, name: str, frames: Iterable[int]) -> list[float]:
        """List the seconds of the processor that a node took at frames or for the shot, each result once [s]."""
        records = [self.record(at(self._graph.nodes[name], frame)) for frame in frames]
        return list({r.key: r.seconds if r.processor is None else r.processor for r in records}.values())
