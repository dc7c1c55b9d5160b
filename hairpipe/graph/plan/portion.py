"""The portion of a shot that a run computes: results at some frames only, each as it is in the whole shot.

What sees all frames of the shot, a collector, is computed by whichever run finds all that it needs in the store.
"""

from collections.abc import Mapping

from hairpipe.errors import BadInput
from hairpipe.graph.file.graph import Graph
from hairpipe.graph.plan.tasks import Inputs, Task, sources


class Portion:
    """The tasks of a run that are asked for, and those that it may compute.

    only   frames to compute; None for all of the run
    asked  tasks that the run must establish
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
        """Whether the run may compute a task; others are only looked up."""
        return task in self.asked or task.node in self.collectors

    def publishes(self, task: Task) -> bool:
        """Whether the run publishes the file of a task."""
        return task.frame is None or task.frame in self.frames

    def _needed(self, tasks: Mapping[Task, Inputs]) -> set[Task]:
        """Find the tasks at the frames, those for the shot, and what they need, without collectors."""
        found: set[Task] = set()
        queue = [task for task in tasks if task.frame is None or task.frame in self.frames]
        while queue:
            task = queue.pop()
            if task not in found and task.node not in self.collectors:
                found.add(task)
                queue.extend(source.task for source in sources(tasks[task]))
        return found


def collectors(graph: Graph) -> list[str]:
    """List the nodes with one value for the shot that need values per frame, in the order of the graph."""
    late: dict[str, bool] = {}
    for node in graph.nodes.values():
        late[node.name] = node.per_frame or any(late[edge.node] for edge in node.edges.values())
    return [name for name, is_late in late.items() if is_late and not graph.nodes[name].per_frame]
