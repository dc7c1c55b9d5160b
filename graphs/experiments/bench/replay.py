"""A scan of a graph, evaluated in this process frame by frame for measurement; results are not stored."""

from dataclasses import dataclass, field
from typing import Any
from warnings import warn

from hairpipe.engine.file.graph import Graph
from hairpipe.engine.node.declare import Cuts, First, Time, Workspace
from hairpipe.engine.plan.arguments import Preparations, build_arguments, name_inputs
from hairpipe.engine.plan.planner import read_result
from hairpipe.engine.plan.tasks import Source, Task, inputs_of
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Store
from hairpipe.engine.worker.worker import keep_freed
from hairpipe.errors import BadInput


@dataclass(eq=False)
class Replay:
    """A scan of a graph, whose inputs are computed and stored as in a run.

    frame, state  the next frame, and the previous state

    Raises BadInput if the node is not a scan, or one of its inputs fails.
    """

    graph: Graph
    store: Store
    name: str
    frame: int = field(init=False)
    state: Any = field(default=None, init=False)
    _preparations: Preparations = field(default_factory=Preparations, init=False)

    def __post_init__(self) -> None:
        keep_freed()
        node = self.graph.node(self.name)
        if node.type.state is None:
            raise BadInput(f"'{self.name}' is not a scan from frame to frame", where=self.graph.path, right="a scan")
        self.frame = self.graph.begin

    def prepare(self, frames: int) -> None:
        """Compute the inputs of the next frames."""
        needed = {edge.node for edge in self.graph.nodes[self.name].edges.values()}
        outcome = run(self.graph.upto(needed), self.store, range(self.frame, self.frame + frames))
        if outcome.interrupted:
            raise KeyboardInterrupt
        if outcome.failures:
            raise BadInput(f"'{self.name}' cannot be measured: {outcome.failures[0]}", where=self.graph.path)

    def arguments(self) -> dict[str, Any]:
        """Build the arguments of the node at this frame, with its preparation."""
        node = self.graph.nodes[self.name]
        frames = tuple(self.graph.all_frames)
        sources = name_inputs(node.type, inputs_of(self.graph, Task(self.name, self.frame), frames), frames, itself)
        cuts = self.graph.cuts_of(node, self.frame, frames)
        special = {Time: Time(self.frame, self.graph.fps), Cuts: cuts, First: self.graph.frames[0], Workspace: None}
        settings = self.graph.settings(node)
        prepared = self._preparations.prepare(node.type, sources, settings, self._load)
        for message in prepared.warnings:
            warn(message, stacklevel=2)
        return build_arguments(node.type, sources, settings, special, self._load) | prepared.arguments

    def advance(self, arguments: dict[str, Any]) -> Any:
        """Evaluate the node at this frame, and advance to the next."""
        node = self.graph.nodes[self.name]
        result = node.type.function(**arguments)
        assert node.type.state is not None
        self.state = node.type.by_output(result)[node.type.state]
        self.frame += 1
        return result

    def _load(self, source: Source, kind: type) -> Any:
        """Load a value from the store, or the value of the node at the previous frame."""
        if source.task.node == self.name:
            return self.state
        return read_result(self.graph, self.store, source.task, source.output)


def itself(source: Source) -> Source:
    """Return the name of a value from its source."""
    return source
