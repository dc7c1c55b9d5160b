"""A graph unrolled over frames: tasks and their inputs, the portion that a run computes, and levels.

Collectors, nodes that depend on all frames, are computed by the run that finds all their inputs in the store. Levels
are computed in sequence; each is divided among machines:

once       values for the shot without inputs per frame
frames-1   values per frame without a scan before them
scans-1    scans, each on one machine
frames-2   values per frame that depend on those, and so on
collect    nodes that depend on all frames

In a wedge, what all variants share comes first: `once-variants`, `frames-1-variants` and `collect-variants` are divided
among variants.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import NamedTuple

from hairpipe.engine.file.graph import BEGIN, Graph, Node
from hairpipe.errors import BadInput


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
        view = node.type.socket(plug).view
        seen: Iterable[int | None] = (task.frame,)
        if view in ("frames", "reached"):
            seen = frames
        elif view == "pair" and task.frame is not None:
            seen = (max(task.frame - 1, graph.begin), task.frame)
        inputs[plug] = [Source(at(source, frame), edge.output) for frame in seen]
    if node.type.state is not None and task.frame is not None and task.frame > graph.begin:
        inputs["previous"] = [Source(Task(task.node, task.frame - 1), node.type.state)]
    return inputs


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


COLLECT = "collect"
VARIANTS = "-variants"
ORDER = ("once", "each", "scan")
"""Modes of nodes in the order in which they are computed."""
NAMES = {"once": "once", "each": "frames", "scan": "scans"}
"""Name of a level by the mode of its nodes."""


class Level(NamedTuple):
    """Nodes that can be computed after the previous levels.

    groups    nodes without consumers in this level, in groups that can be computed concurrently; none: all nodes
    by_frame  whether frames can be computed concurrently, too
    """

    name: str
    groups: tuple[tuple[str, ...], ...]
    by_frame: bool


def levels_of(graph: Graph) -> list[Level]:
    """List the levels of a graph in order."""
    late = set(collectors(graph))
    scans: dict[str, int] = {}
    found: dict[tuple[int, int, bool], list[str]] = {}
    for name, node in graph.nodes.items():
        sources = [edge.node for edge in node.edges.values()]
        if late.intersection(sources):
            late.add(name)
        scans[name] = max([scans[other] + (graph.nodes[other].type.mode == "scan") for other in sources], default=0)
        if name not in late:
            mode = node.type.mode
            found.setdefault((scans[name], ORDER.index(mode), mode != "scan" and _varies(name)), []).append(name)
    levels = []
    for (number, place, varies), names in sorted(found.items()):
        mode = ORDER[place]
        name = NAMES[mode] + (f"-{number + 1}" if mode != "once" else "") + (VARIANTS if varies else "")
        groups = tuple((name,) for name in names) if mode == "scan" else _by_variant(_ends(graph, names))
        levels.append(Level(name, groups, mode == "each"))
    if ends := _ends(graph, [name for name in graph.nodes if name in late and _varies(name)]):
        levels.append(Level(COLLECT + VARIANTS, _by_variant(ends), False))
    return [*levels, Level(COLLECT, (), False)] if late else levels


def _varies(name: str) -> bool:
    return BEGIN in name


def _ends(graph: Graph, names: list[str]) -> list[str]:
    needed = {edge.node for name in names for edge in graph.nodes[name].edges.values()}
    return [name for name in names if name not in needed]


def _by_variant(names: list[str]) -> tuple[tuple[str, ...], ...]:
    groups: dict[str, list[str]] = {}
    for name in names:
        groups.setdefault(name.partition(BEGIN)[2], []).append(name)
    return tuple(map(tuple, groups.values()))
