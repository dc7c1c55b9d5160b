"""Edges of a graph: reading, and checks of types and frames."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Any

from hairpipe.engine.file.graph import Edge, Node
from hairpipe.engine.file.registry import Registry
from hairpipe.engine.node.declare import SINGLE, NodeType, Socket
from hairpipe.engine.node.messages import brief, closest, listed, nearest
from hairpipe.engine.node.signature import Spent
from hairpipe.errors import BadInput

Place = Callable[[Sequence[str]], str]
MOST_SOURCES = 4
"""Maximum number of nodes that a message suggests."""


def read_edges(given: Any, node_type: NodeType, place: Place) -> dict[str, Edge]:
    """Read the table `in`: socket to "node" or "node.output", or to a list of those where the socket takes many."""
    if not isinstance(given, dict):
        raise BadInput(f"in = {brief(given)} is not a table", where=place(["in"]), right='in.body = "node"')
    edges = {}
    for name, value in given.items():
        where = place(["in", name])
        if name not in node_type.sockets:
            raise BadInput(
                f"no socket '{name[:60]}'", where=where, right=suggest_socket(name, node_type.sockets.values())
            )
        socket = node_type.sockets[name]
        sources = value if socket.many and isinstance(value, list) else [value]
        if not sources or not all(isinstance(source, str) for source in sources):
            right = '"node" or "node.output"' + (", or a list of those" if socket.many else ", one edge")
            raise BadInput(f"in.{name} = {brief(value)}", where=where, right=right)
        plugs = [f"{name}.{number}" for number in range(len(sources))] if socket.many else [name]
        edges |= {plug: Edge(*source.partition(".")[::2]) for plug, source in zip(plugs, sources, strict=True)}
    return edges


def suggest_socket(name: str, sockets: Collection[Socket]) -> str:
    """Suggest the socket closest to an unknown name, or the sockets of a type of that name; list all sockets."""
    types = {socket.name: socket.type.__name__ for socket in sockets}
    plain = name.lower().replace("_", "")
    near = [socket for socket, kind in types.items() if kind.lower() == plain] or [closest(name, list(types))]
    hint = " or ".join(f"'{socket}'" for socket in near if socket)
    listing = listed([f"{socket} ({kind})" for socket, kind in types.items()])
    return (f"did you mean {hint}? " if hint else "") + (f"sockets: {listing}" if types else "there are none")


class Incomplete(BadInput):
    """A node has no value for a required input or setting.

    node  name of the node
    """

    def __init__(self, node: str, what: str, where: object, right: str | None) -> None:
        super().__init__(what, where=where, right=right)
        self.node = node


def connect(nodes: dict[str, Node], place: Callable[[str, Sequence[str]], str], registry: Registry) -> dict[str, Node]:
    """Check the types of all edges, and add the names of omitted outputs."""
    connected = {}
    for node in nodes.values():
        plugged = {plug.partition(".")[0] for plug in node.edges}
        for socket in node.type.sockets.values():
            if not socket.optional and socket.name not in plugged:
                what = f"socket '{socket.name}' is not connected, it takes {socket.type.__name__}"
                where = f"{place(node.name, ['in'])} {node.type.name}"
                right = suggest_source(socket, node, nodes, registry)
                raise Incomplete(node.name, what, where, f"in.{socket.name} = {right}")
        edges = {}
        for plug, edge in node.edges.items():
            where = f"{place(node.name, ['in', node.type.socket(plug).name])} {node.type.name}"
            if edge.node not in nodes:
                right = nearest(edge.node, list(nodes))
                raise BadInput(f"in.{plug}: no node '{edge.node[:60]}'", where=where, right=right)
            try:
                edges[plug] = check_edge(node, plug, edge, nodes[edge.node], where)
            except WrongType as fault:
                right = suggest_source(node.type.socket(plug), node, nodes, registry)
                raise BadInput(fault.what, where=where, right=right) from None
        connected[node.name] = replace(node, edges=edges)
    return connected


class WrongType(BadInput):
    """The type of the output differs from that of the socket."""


def suggest_source(socket: Socket, node: Node, nodes: dict[str, Node], registry: Registry) -> str:
    """Suggest nodes with an output of the type of a socket; if there are none, node types."""
    kind = socket.type.__name__
    edges = [edge for other in nodes.values() if other is not node for edge in edges_of_type(socket.type, other)]
    if edges:
        return f"{' or '.join(edges[:MOST_SOURCES])}, which gives {kind}"
    return f"a node that gives {kind}: {listed(registry.types_with_output(socket.type)) or 'no type does'}"


def edges_of_type(kind: type, node: Node) -> list[str]:
    """List the edges from a node whose type is this one; the output is named if there are several."""
    outputs = [name for name, given in node.type.outputs.items() if given is kind]
    return [f'"{node.name}"'] if len(outputs) == 1 else [f'"{node.name}.{name}"' for name in outputs]


def check_edge(node: Node, plug: str, edge: Edge, source: Node, where: str) -> Edge:
    """Check output, type and frames of one edge; the output may be omitted if only one has the type.

    Types are compared for equality: a value contains exactly the fields of its type, so derived types differ.
    """
    socket = node.type.socket(plug)
    if socket.type is Spent:
        return check_spent(plug, edge, source, where)
    fitting = [output for output, kind in source.type.outputs.items() if kind is socket.type]
    if edge.output and edge.output not in source.type.outputs:
        named = [output for output in source.type.outputs if output != SINGLE]
        right = nearest(edge.output, named) if named else f'"{source.name}", it has one output without a name'
        raise BadInput(f"in.{plug}: '{source.name}' has no output '{edge.output[:60]}'", where=where, right=right)
    if not fitting or (edge.output and edge.output not in fitting):
        given = source.type.outputs.get(edge.output)
        what = given.__name__ if given else ", ".join(kind.__name__ for kind in source.type.outputs.values())
        raise WrongType(f"in.{plug} takes {socket.type.__name__}, '{source.name}' gives {what}")
    if not edge.output and len(fitting) > 1:
        right = "one of " + ", ".join(f'"{source.name}.{output}"' for output in fitting)
        raise BadInput(f"in.{plug}: several outputs of '{source.name}' fit", where=where, right=right)
    if source.per_frame and not node.per_frame and socket.view not in ("frames", "reached"):
        what = f"in.{plug}: '{source.name}' gives a value per frame, '{node.name}' takes one for the shot"
        kind = socket.type.__name__
        right = f"a node that gives one {kind} for the shot, or a type that takes Frames[{kind}]"
        raise BadInput(what, where=where, right=right)
    if source.per_frame and node.type.prepare and socket.name in node.type.prepare.sockets:
        what = f"in.{plug}: '{source.name}' gives a value per frame, '{node.name}' is prepared with it for all frames"
        raise BadInput(what, where=where, right=f"a node that gives one {socket.type.__name__} for the shot")
    return Edge(source.name, edge.output or fitting[0])


def check_spent(plug: str, edge: Edge, source: Node, where: str) -> Edge:
    """Check an edge of the computation time of results, of a node with one result per frame and any output."""
    if edge.output:
        what = f"in.{plug} takes the time of a node, '{edge.output[:60]}' is one of its outputs"
        raise BadInput(what, where=where, right=f'"{source.name}"')
    if not source.per_frame:
        what = f"in.{plug} takes the time of each frame, '{source.name}' has one value for the shot"
        raise BadInput(what, where=where, right="a node with a value per frame")
    outputs = source.type.outputs
    return Edge(source.name, next(name for name in outputs if name != source.type.state or len(outputs) == 1))
