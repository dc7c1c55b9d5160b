"""Reads results: the value of a node at a frame."""

from collections.abc import Iterable
from typing import Any

from hairpipe.engine.file.graph import Graph
from hairpipe.engine.plan.planner import explain
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.run.events import CODEC
from hairpipe.engine.store.record import Record
from hairpipe.engine.store.store import LostObject, Store
from hairpipe.engine.store.values import Values, codec_named
from hairpipe.errors import BadInput


def read_result(
    graph: Graph,
    store: Store,
    task: Task,
    output: str | None = None,
    frames: Iterable[int] | None = None,
    codec: str = CODEC,
) -> Any:
    """Read a result from the store: a value of its type, or a File; BadInput where it has not been computed.

    output  of a node with several; without one, the only one or the first
    frames  of the run that has computed it, all for None
    """
    return read_value(graph, store, task, explain(graph, store, task, frames).record, output, codec)


def read_value(
    graph: Graph, store: Store, task: Task, record: Record | None, output: str | None = None, codec: str = CODEC
) -> Any:
    """Read an output of a task from the store; BadInput as for `fetch`.

    record  of the task; None where it has not been computed
    """
    node = graph.nodes[task.node]
    name = graph.output(task.node, output)
    if record is None:
        raise BadInput(f"'{task}' has not been computed", where=graph.path, right=f"hairpipe run --to {task.node}")
    if not store.has(record.outputs[name].object):
        what = f"output '{name}' of '{task}' was not kept"
        raise BadInput(what, where=store.root, right="a run with checkpoint = 1 and another --cache")
    try:
        return Values(store, codec_named(codec), 0).get(record.outputs[name].object, node.type.outputs[name])
    except LostObject:
        right = "hairpipe run computes it again"
        raise BadInput(f"'{task}' is not in the store any more", where=store.root, right=right) from None
