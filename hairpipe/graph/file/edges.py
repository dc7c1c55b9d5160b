"""The edges of a graph: which output goes into which socket, and whether the types and frames fit."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from hairpipe.errors import BadInput
from hairpipe.graph.file.graph import Edge, Node
from hairpipe.graph.node.declare import SINGLE, NodeType
from hairpipe.graph.node.messages import brief, nearest

Place = Callable[[Sequence[str]], str]


def read_edges(given: Any, node_type: NodeType, place: Place) -> dict[str, Edge]:
    """Read the table `in`: socket to "node" or "node.output", or to a list of those where the socket takes many."""
    if not isinstance(given, dict):
        raise BadInput(f"in = {brief(given)} is no table", where=place(["in"]), right='in.body = "node"')
    edges = {}
    for name, value in given.items():
        where = place(["in", name])
        if name not in node_type.sockets:
            raise BadInput(f"no socket '{name[:60]}'", where=where, right=nearest(name, list(node_type.sockets)))
        socket = node_type.sockets[name]
        sources = value if socket.many and isinstance(value, list) else [value]
        if not sources or not all(isinstance(source, str) for source in sources):
            right = '"node" or "node.output"' + ", or a list of those" * socket.many
            raise BadInput(f"in.{name} = {brief(value)}", where=where, right=right)
        plugs = [f"{name}.{number}" for number in range(len(sources))] if socket.many else [name]
        edges |= {plug: Edge(*source.partition(".")[::2]) for plug, source in zip(plugs, sources, strict=True)}
    for socket in node_type.sockets.values():
        if socket.name not in given and not socket.optional:
            right = f'in.{socket.name} = "a node that gives {socket.type.__name__}"'
            raise BadInput(f"socket '{socket.name}' is not connected", where=place(["in"]), right=right)
    return edges


def connect(nodes: dict[str, Node], place: Callable[[str, Sequence[str]], str]) -> dict[str, Node]:
    """Check that every edge comes from a node that gives what the socket takes, and name its output."""
    connected = {}
    for node in nodes.values():
        edges = {}
        for plug, edge in node.edges.items():
            where = f"{place(node.name, ['in', node.type.socket(plug).name])} {node.type.name}"
            if edge.node not in nodes:
                right = nearest(edge.node, list(nodes))
                raise BadInput(f"in.{plug}: no node '{edge.node[:60]}'", where=where, right=right)
            edges[plug] = check_edge(node, plug, edge, nodes[edge.node], where)
        connected[node.name] = replace(node, edges=edges)
    return connected


def check_edge(node: Node, plug: str, edge: Edge, source: Node, where: str) -> Edge:
    """Check output, type and frames of one edge; an output that is not named is the only one that fits.

    A value is built of exactly the fields of the type that the socket takes: one of a derived type does not fit.
    """
    socket = node.type.socket(plug)
    fitting = [output for output, kind in source.type.outputs.items() if kind is socket.type]
    if edge.output and edge.output not in source.type.outputs:
        right = nearest(edge.output, [output for output in source.type.outputs if output != SINGLE])
        raise BadInput(f"in.{plug}: '{source.name}' has no output '{edge.output[:60]}'", where=where, right=right)
    if not fitting or (edge.output and edge.output not in fitting):
        given = source.type.outputs.get(edge.output)
        what = given.__name__ if given else ", ".join(kind.__name__ for kind in source.type.outputs.values())
        right = f"a node that gives {socket.type.__name__}"
        raise BadInput(f"in.{plug}: '{source.name}' gives {what}", where=where, right=right)
    if not edge.output and len(fitting) > 1:
        right = "one of " + ", ".join(f'"{source.name}.{output}"' for output in fitting)
        raise BadInput(f"in.{plug}: several outputs of '{source.name}' fit", where=where, right=right)
    if source.per_frame and not node.per_frame and socket.view not in ("frames", "reached"):
        what = f"in.{plug}: '{source.name}' gives a value per frame, '{node.name}' takes one for the shot"
        raise BadInput(what, where=where, right=f"{node.type.name} would have to take Frames[{socket.type.__name__}]")
    if source.per_frame and node.type.prepare and socket.name in node.type.prepare.sockets:
        what = f"in.{plug}: '{source.name}' gives a value per frame, '{node.name}' is prepared with it for all frames"
        raise BadInput(what, where=where, right=f"a node that gives one {socket.type.__name__} for the shot")
    return Edge(source.name, edge.output or fitting[0])
