"""A scan of a graph in this process, frame after frame, nothing of which is stored: for whoever measures it."""

from dataclasses import dataclass, field
from typing import Any

from hairpipe.errors import BadInput
from hairpipe.graph.declare import SINGLE
from hairpipe.graph.events import CODEC
from hairpipe.graph.fetch import fetch
from hairpipe.graph.frames import Frames, Pair, Time
from hairpipe.graph.graph import Graph
from hairpipe.graph.memory import keep_freed
from hairpipe.graph.run import run
from hairpipe.graph.settings import build_settings
from hairpipe.graph.store import Store
from hairpipe.graph.tasks import Source, Task, inputs_of


@dataclass(eq=False)
class Replay:
    """A node of a graph that depends on its own previous frame; what it depends on is computed and stored as usual.

    Raises BadInput where the node is no scan, or what it depends on fails.
    """

    graph: Graph
    store: Store
    name: str
    codec: str = CODEC
    frame: int = field(init=False)
    _state: Any = field(default=None, init=False)

    def __post_init__(self) -> None:
        keep_freed()
        node = self.graph.node(self.name)
        if node.type.state is None:
            raise BadInput(f"'{self.name}' does not go from frame to frame", where=self.graph.path, right="a scan")
        self.frame = self.graph.frames[0]

    def prepare(self, frames: int) -> None:
        """Compute what so many frames from here on depend on."""
        needed = {edge.node for edge in self.graph.nodes[self.name].edges.values()}
        outcome = run(self.graph.upto(needed), self.store, range(self.frame, self.frame + frames))
        if outcome.interrupted:
            raise KeyboardInterrupt
        if outcome.failures:
            raise BadInput(f"'{self.name}' cannot be measured: {outcome.failures[0]}", where=self.graph.path)

    def arguments(self) -> dict[str, Any]:
        """Build what the node is given at this frame."""
        node, sources = self.graph.nodes[self.name], inputs_of(self.graph, self._task, tuple(self.graph.all_frames))
        built: dict[str, Any] = {}
        for name, socket in node.type.sockets.items():
            seen = tuple(self._seen(sources.get(plug), socket.view) for plug in socket.plugs(node.edges))
            built[name] = (seen or None) if socket.many else seen[0]
        built |= {name: Time(self.frame, self.graph.fps) for name in node.type.asks_time}
        return built | {"previous": self._state} | build_settings(node.type, node.settings)

    def advance(self, arguments: dict[str, Any]) -> Any:
        """Evaluate the node at this frame with its arguments, and go on to the next."""
        node = self.graph.nodes[self.name]
        result = node.type.function(**arguments)
        outputs = {SINGLE: result} if SINGLE in node.type.outputs else result._asdict()
        assert node.type.state is not None
        self._state = outputs[node.type.state]
        self.frame += 1
        return result

    @property
    def _task(self) -> Task:
        return Task(self.name, self.frame)

    def _seen(self, sources: list[Source] | None, view: str) -> Any:
        """Read what a socket sees."""
        if sources is None:
            return None
        if view == "frames":
            known = {source.task.frame: source for source in sources}
            return Frames(tuple(self.graph.all_frames), lambda frame: self._value(known[frame]))
        values = [self._value(source) for source in sources]
        return Pair(*values) if view == "pair" else values[0]

    def _value(self, source: Source) -> Any:
        return fetch(self.graph, self.store, source.task, source.output, self.codec)
