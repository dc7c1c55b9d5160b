"""A graph unrolled over frames: which evaluation needs which."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import NamedTuple

from hairpipe.graph.file.graph import Graph, Node


class Task(NamedTuple):
    """A node at a frame; the frame of a value for the shot is None."""

    node: str
    frame: int | None

    def __str__(self) -> str:
        """Write `hair@12`, or `groom`."""
        return self.node if self.frame is None else f"{self.node}@{self.frame}"


class Source(NamedTuple):
    """Where a value comes from: an output of a task."""

    task: Task
    output: str


Inputs = dict[str, list[Source]]
"""What a task sees by each edge: one source; the previous and the current one; or one for every frame."""


def inputs_of(graph: Graph, task: Task, frames: tuple[int, ...]) -> Inputs:
    """List the sources of a task; `frames` are those that a `Frames` socket sees.

    At the frame that scans begin at a pair is the current value twice, and a scan has no `previous`.
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
    """Frames of its source that a socket sees."""
    if view in ("frames", "reached"):
        return frames
    if view == "pair" and frame is not None:
        return (max(frame - 1, first), frame)
    return (frame,)


def at(node: Node, frame: int | None) -> Task:
    """The task of a node at a frame; a value for the shot is the same at all of them."""
    return Task(node.name, frame if node.per_frame else None)


def unroll(graph: Graph, frames: tuple[int, ...]) -> dict[Task, Inputs]:
    """List the tasks behind all nodes at these frames, each after those it needs.

    A scan needs every frame from its beginning on, whatever is selected.
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
    """Order tasks so that each stands after those it needs: by node, then by frame."""
    rank = {name: number for number, name in enumerate(graph.nodes)}
    return lambda task: (rank[task.node], task.frame or 0)
