"""Thins the states of scans once a run is over: what is needed to go on from somewhere, not from everywhere."""

from collections.abc import Iterator

from hairpipe.graph.graph import Node
from hairpipe.graph.record import read_record
from hairpipe.graph.resolve import Resolver
from hairpipe.graph.store import Store
from hairpipe.graph.tasks import Task


def thin(resolver: Resolver) -> int:
    """Remove the states of complete scans but for every n-th frame's and the last; returns how many objects went.

    An object that some record holds in another role stays.
    """
    kept: set[str] = set()
    spare: set[str] = set()
    for node in resolver.graph.nodes.values():
        state = resolver.thinnable(node)
        tasks = [task for task in resolver.tasks if task.node == node.name]
        if state is not None and all(task in resolver.results for task in tasks):
            for task in tasks:
                keep = is_checkpoint(node, task, resolver.graph.frames[0]) or task == tasks[-1]
                (kept if keep else spare).add(resolver.results[task].outputs[state].object)
    spare = {name for name in spare - kept if resolver.store.has(name)}
    if spare:
        spare -= set(held(resolver.store))
    for name in spare:
        resolver.store.remove(resolver.store.object_path(name))
    return len(spare)


def is_checkpoint(node: Node, task: Task, first: int) -> bool:
    """Whether a frame is an n-th one, counted from the first of the graph."""
    return task.frame is not None and (task.frame - first + 1) % node.checkpoint == 0


def held(store: Store) -> Iterator[str]:
    """Name the objects that any record of the store holds other than as the state of a scan."""
    for path in (store.root / "actions").glob("??/*.json"):
        record = read_record(path.read_text(encoding="utf-8", errors="replace"))
        if record:
            yield from (name for name, _ in record.objects(without=record.state))
