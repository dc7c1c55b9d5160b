"""Plays a graph: a scan, and the nodes after it up to one node, are evaluated frame by frame in this process.

Results are not stored, so settings may change from one frame to the next. Inputs come from the store. After the last
frame it restarts.
"""

import time
from typing import Any, NamedTuple

from hairpipe.engine.code import CodeReader
from hairpipe.engine.file.graph import Graph, Node
from hairpipe.engine.hosts.host import environment
from hairpipe.engine.node.declare import Cuts, First, Time, Workspace
from hairpipe.engine.plan.arguments import Preparations, build_arguments, name_inputs
from hairpipe.engine.plan.planner import Planner
from hairpipe.engine.plan.tasks import Source, Task, inputs_of
from hairpipe.engine.store.store import Store
from hairpipe.engine.store.values import Values
from hairpipe.engine.worker.machine_code import claim_kernels, guard_kernels, kernels_environment, kernels_parent
from hairpipe.errors import BadInput


class Played(NamedTuple):
    """A frame that was played."""

    frame: int
    values: dict[str, Any]  # outputs of the shown node, by name
    seconds: dict[str, float]  # time of each node, without reading its inputs [s]


class Player:
    """Plays a graph up to a node.

    nodes  nodes to evaluate, in order; BadInput if no scan leads to the shown node, or if one of them needs all
           frames, or a folder
    """

    def __init__(self, graph: Graph, store: Store, node: str) -> None:
        guard_kernels()
        self._store, self._node = store, node
        self._values = Values(store, 0)
        self._stored: dict[str, Any] = {}
        self._made: dict[Source, Any] = {}
        self._preparations = Preparations()
        self._frame = graph.begin - 1
        self._seconds = {}
        self.take(graph)

    def take(self, graph: Graph) -> None:
        """Go on with other settings; BadInput, and nothing changes, where what goes in has not been computed."""
        nodes = played_nodes(graph.upto([self._node]), self._node)
        needed = {edge.node for node in nodes for edge in node.edges.values()} - {node.name for node in nodes}
        planner = Planner(graph.upto(needed) if needed else graph.upto([self._node]), self._store, None)
        missing = [entry.task for entry in planner.entries() if entry.task.node in needed and entry.status != "cached"]
        if missing:
            what = f"{missing[0]} has not been computed"
            raise BadInput(what, where=graph.path, right=f"hairpipe run --to {missing[0].node}")
        self._records = planner.resolver.results
        self.graph, self.nodes = graph, nodes

    def advance(self) -> Played:
        """Evaluate the next frame; an error of a node passes through, and the next call restarts."""
        last = self.graph.frames[1]
        frame = self.graph.begin if self._frame >= last else self._frame + 1
        self._frame = last  # until it is done
        self._seconds = {}
        for node in self.nodes:
            for output, value in self._evaluate(node, frame).items():
                self._made[Source(Task(node.name, frame), output)] = value
        recent = (frame - 1, frame)
        self._made = {source: value for source, value in self._made.items() if source.task.frame in recent}
        self._frame = frame
        values = {o: self._made[Source(Task(self._node, frame), o)] for o in self.nodes[-1].type.outputs}
        return Played(frame, values, self._seconds)

    def _evaluate(self, node: Node, frame: int) -> dict[str, Any]:
        kind = node.type
        settings = self.graph.settings(node)
        inputs = inputs_of(self.graph, Task(node.name, frame), (frame,))
        named = name_inputs(kind, inputs, (frame,), self._name)
        cuts = self.graph.cuts_of(node, frame, (frame,))
        special = {Time: Time(frame, self.graph.fps), Cuts: cuts, First: self.graph.frames[0]}
        arguments = build_arguments(kind, named, settings, special, self._load)
        prepared = self._preparations.prepare(kind, named, settings, self._load)
        begun = time.perf_counter()
        result = kind.by_output(kind.function(**arguments, **prepared.arguments))
        self._seconds[node.name] = time.perf_counter() - begun
        return result

    def _name(self, source: Source) -> Any:
        """Name of a stored object; what was made here is named by where it came from."""
        return source if source in self._made else self._records[source.task].outputs[source.output].object

    def _load(self, name: Any, kind: type) -> Any:
        if isinstance(name, Source):
            return self._made[name]
        if name not in self._stored:
            self._stored[name] = self._values.get(name, kind)
        return self._stored[name]


def playing_environment(graph: Graph, store: Store) -> dict[str, str]:
    """Environment of a process that plays a graph: on one thread, with the kernels of the sources as they are.

    BadInput where others may write to that folder, OSError where there can be none.
    """
    reader = CodeReader(store.remember, graph.folder)
    modules = {node.type.module for node in graph.nodes.values()}
    return environment(1, kernels_environment(claim_kernels(kernels_parent()), reader, modules))


def played_nodes(graph: Graph, name: str) -> list[Node]:
    """List the scans that lead to a node, and what lies between; BadInput where that cannot be played."""
    played: list[Node] = []
    for node in graph.nodes.values():
        follows = any(edge.node in {other.name for other in played} for edge in node.edges.values())
        if node.type.mode == "scan" or (node.per_frame and follows):
            played.append(node)
    if not played or played[-1].name != name:
        right = "a simulation, or hair made of one"
        raise BadInput(f"'{name}' does not depend on a simulation", where=graph.path, right=right)
    for node in played:
        if node.type.asks(Workspace) or any(s.view in ("frames", "reached") for s in node.type.sockets.values()):
            raise BadInput(f"'{node.name}' cannot be played", where=graph.path, right="a node of values at a frame")
    return played
