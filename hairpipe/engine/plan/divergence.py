"""Divergence of scans: nodes with `Reached` inputs continue with the frames before."""

from typing import NamedTuple

from hairpipe.engine.plan.resolve import Resolver
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.store.digest import digest


class Divergence(NamedTuple):
    """A scan that diverged.

    lost       tasks of the scan, from the failed one on
    consumers  tasks of other nodes that continue with the frames before
    """

    lost: frozenset[Task]
    consumers: frozenset[Task]


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
