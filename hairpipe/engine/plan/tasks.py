"""A graph unrolled over frames: tasks and their inputs."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import NamedTuple

from hairpipe.engine.file.graph import Graph, Node


class Task(NamedTuple):
    """A node at a frame; None: a value for the shot."""

    node: str
    frame: int | None

    def __str__(self) -> str:
        """Write `hair@12`, or `groom`."""
        return self.node if self.frame is None else f"{self.node}@{self.frame}"


class Source(NamedTuple):
    """The source of a value: an output of a task."""

    task: Task
    output: str


Inputs = dict[str, list[Source]]
"""Sources of a task by edge: one; the previous and the current one; or one for every frame."""


def inputs_of(graph: Graph, task: Task, frames: tuple[int, ...]) -> Inputs:
    """List the sources of a task; `frames` are those of a `Frames` socket.

    At the first frame of scans a pair is the current value twice, and `previous` is absent.
    """
    node = graph.nodes[task.node]
    inputs: Inputs = {}
    for plug, edge in node.edges.items():
        source = graph.nodes[edge.node]
        seen = frames_seen(node.type.socket(plug).view, task.frame, frames, graph.begin)
        inputs[plug] = [Source(at(source, frame), edge.output) for frame in seen]
    if node.type.state is not None and task.frame is not None and task.frame > graph.begin:
        inputs["previous"] = [Source(Task(task.node, task.frame - 1), node.type.state)]
    return inputs


def frames_seen(view: str, frame: int | None, frames: tuple[int, ...], first: int) -> Iterable[int | None]:
    """Return the frames of the source of a socket."""
    if view in ("frames", "reached"):
        return frames
    if view == "pair" and frame is not None:
        return (max(frame - 1, first), frame)
    return (frame,)


def at(node: Node, frame: int | None) -> Task:
    """Return the task of a node at a frame; a value for the shot has one task."""
    return Task(node.name, frame if node.per_frame else None)


def unroll(graph: Graph, frames: tuple[int, ...]) -> dict[Task, Inputs]:
    """List the tasks of all nodes at these frames in order of dependency.

    A scan needs all frames from its first on.
    """
    tasks: dict[Task, Inputs] = {}
    wanted: defaultdict[str, set[int | None]] = defaultdict(set)
    for node in reversed(graph.nodes.values()):
        own = wanted[node.name] | {at(node, frame).frame for frame in frames}
        if node.type.mode == "scan":
            own = set(range(graph.begin, max(frame for frame in own if frame is not None) + 1))
        for frame in own:
            task = Task(node.name, frame)
            tasks[task] = inputs_of(graph, task, frames)
            for source in sources(tasks[task]):
                wanted[source.task.node].add(source.task.frame)
    return {task: tasks[task] for task in sorted(tasks, key=order_of(graph))}


def is_beyond(task: Task, limits: Mapping[str, int]) -> bool:
    """Whether a task is stopped: it is beyond the last frame of its node, or needs all frames."""
    limit = limits.get(task.node)
    return limit is not None and (task.frame is None or task.frame > limit)


def sources(inputs: Inputs) -> Iterator[Source]:
    """Iterate over all sources of a task."""
    for found in inputs.values():
        yield from found


def order_of(graph: Graph) -> Callable[[Task], tuple[int, int]]:
    """Return the sort key for the order of dependency: by node, then by frame."""
    rank = {name: number for number, name in enumerate(graph.nodes)}
    return lambda task: (rank[task.node], task.frame or 0)
