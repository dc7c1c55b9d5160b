"""The edges of a graph: which output goes into which socket, and whether the types and frames fit."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from hairpipe.errors import BadInput
from hairpipe.graph.declare import SINGLE, NodeType
from hairpipe.graph.graph import Edge, Node
from hairpipe.graph.settings import nearest

Place = Callable[[Sequence[str]], str]


def read_edges(given: Any, node_type: NodeType, place: Place) -> dict[str, Edge]:
    """Read the table `in`: socket to "node" or "node.output"."""
    if not isinstance(given, dict):
        raise BadInput(f"in = {str(given)[:60]!r} is no table", where=place(["in"]), right='in.body = "node"')
    for socket, source in given.items():
        if socket not in node_type.sockets:
            right = nearest(socket, list(node_type.sockets))
            raise BadInput(f"no socket '{socket[:60]}'", where=place(["in", socket]), right=right)
        if not isinstance(source, str):
            raise BadInput(
                f"in.{socket} = {str(source)[:60]}", where=place(["in", socket]), right='"node" or "node.output"'
            )
    for socket in node_type.sockets.values():
        if socket.name not in given and not socket.optional:
            right = f'in.{socket.name} = "a node that gives {socket.type.__name__}"'
            raise BadInput(f"socket '{socket.name}' is not connected", where=place(["in"]), right=right)
    return {socket: Edge(*source.partition(".")[::2]) for socket, source in given.items()}


def connect(nodes: dict[str, Node], place: Callable[[str, Sequence[str]], str]) -> dict[str, Node]:
    """Check that every edge comes from a node that gives what the socket takes, and name its output."""
    connected = {}
    for node in nodes.values():
        edges = {}
        for socket, edge in node.edges.items():
            where = f"{place(node.name, ['in', socket])} {node.type.name}"
            if edge.node not in nodes:
                right = nearest(edge.node, list(nodes))
                raise BadInput(f"in.{socket}: no node '{edge.node[:60]}'", where=where, right=right)
            edges[socket] = check_edge(node, socket, edge, nodes[edge.node], where)
        connected[node.name] = replace(node, edges=edges)
    return connected


def check_edge(node: Node, name: str, edge: Edge, source: Node, where: str) -> Edge:
    """Check output, type and frames of one edge; an output that is not named is the only one that fits."""
    socket = node.type.sockets[name]
    fitting = [output for output, kind in source.type.outputs.items() if issubclass(kind, socket.type)]
    if edge.output and edge.output not in source.type.outputs:
        right = nearest(edge.output, [output for output in source.type.outputs if output != SINGLE])
        raise BadInput(f"in.{name}: '{source.name}' has no output '{edge.output[:60]}'", where=where, right=right)
    if not fitting or (edge.output and edge.output not in fitting):
        given = source.type.outputs.get(edge.output)
        what = given.__name__ if given else ", ".join(kind.__name__ for kind in source.type.outputs.values())
        right = f"a node that gives {socket.type.__name__}"
        raise BadInput(f"in.{name}: '{source.name}' gives {what}", where=where, right=right)
    if not edge.output and len(fitting) > 1:
        right = "one of " + ", ".join(f'"{source.name}.{output}"' for output in fitting)
        raise BadInput(f"in.{name}: several outputs of '{source.name}' fit", where=where, right=right)
    if source.per_frame and not node.per_frame and socket.view != "frames":
        what = f"in.{name}: '{source.name}' gives a value per frame, '{node.name}' takes one for the shot"
        raise BadInput(what, where=where, right=f"{node.type.name} would have to take Frames[{socket.type.__name__}]")
    return Edge(source.name, edge.output or fitting[0])
