"""Runs that end early: a scan that diverges at a frame, and those who take what it has reached."""

from typing import NamedTuple

from hairpipe.graph.plan.resolve import Resolver
from hairpipe.graph.plan.tasks import Task
from hairpipe.graph.store.digest import digest


class Ending(NamedTuple):
    """What becomes of a scan that ends.

    lost   its tasks, from the one that failed on
    takers tasks of others that go on with what came before
    """

    lost: frozenset[Task]
    takers: frozenset[Task]


def ending_note(key: str) -> str:
    """Name what the store notes of a task with this key that diverged, for a plan, which runs nothing."""
    return digest("ending", key)


def end(resolver: Resolver, failed: Task) -> Ending | None:
    """Take a scan's tasks from one on out of the inputs of those who take what was reached; in place.

    None, and nothing is changed, where anybody needs all of it, where nobody takes any, or where nothing was reached.
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
    return Ending(lost, frozenset(task for task, _ in left)) if left else None
