"""The portion of a shot that a run computes: results at some frames, equal to those of the whole shot.

Collectors, nodes that depend on all frames, are computed by the run that finds all their inputs in the store.
"""

from collections.abc import Mapping

from hairpipe.engine.file.graph import Graph
from hairpipe.engine.plan.tasks import Inputs, Task, is_beyond, sources
from hairpipe.errors import BadInput


class Portion:
    """Requested tasks of a run, and those that it may compute.

    only   frames to compute; None for all of the run
    asked  requested tasks
    """

    def __init__(
        self, graph: Graph, tasks: Mapping[Task, Inputs], frames: tuple[int, ...], only: tuple[int, ...] | None
    ) -> None:
        outside = sorted(set(only or ()) - set(frames))
        if outside:
            what = f"--only: frame {outside[0]} is not a frame of the run"
            raise BadInput(what, where=graph.path, right="frames that --frames selects")
        self.frames = frozenset(frames if only is None else only)
        self.collectors = frozenset() if only is None else frozenset(collectors(graph))
        self.asked = set(tasks) if only is None else self._needed(tasks)

    def computes(self, task: Task) -> bool:
        """Whether the run may compute a task; other results are only looked up."""
        return task in self.asked or task.node in self.collectors

    def publishes(self, task: Task) -> bool:
        """Whether the run publishes the file of a task."""
        return task.frame is None or task.frame in self.frames

    def ends(self, task: Task, limits: Mapping[str, int]) -> bool:
        """Whether a task is the last of its node that the run computes, also where the node is stopped at a frame."""
        following = Task(task.node, (task.frame or 0) + 1)
        return following not in self.asked or is_beyond(following, limits)

    def _needed(self, tasks: Mapping[Task, Inputs]) -> set[Task]:
        """Find the tasks at the frames and those for the shot, with their dependencies, without collectors."""
        found: set[Task] = set()
        queue = [task for task in tasks if task.frame is None or task.frame in self.frames]
        while queue:
            task = queue.pop()
            if task not in found and task.node not in self.collectors:
                found.add(task)
                queue.extend(source.task for source in sources(tasks[task]))
        return found


def collectors(graph: Graph) -> list[str]:
    """List the nodes with one value for the shot that depend on values per frame, in the order of the graph."""
    late: dict[str, bool] = {}
    for node in graph.nodes.values():
        late[node.name] = node.per_frame or any(late[edge.node] for edge in node.edges.values())
    return [name for name, is_late in late.items() if is_late and not graph.nodes[name].per_frame]
