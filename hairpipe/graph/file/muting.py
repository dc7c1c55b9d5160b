"""`mute = true`: a node that is passed by, as if its input of the same type were its output."""

from collections.abc import Mapping
from dataclasses import replace

from hairpipe.errors import BadInput
from hairpipe.graph.file.graph import Edge, Node
from hairpipe.graph.file.read import GraphText

MUTE = "mute"


def muted_nodes(text: GraphText, tables: Mapping[str, dict[str, object]]) -> set[str]:
    """Return the names of muted nodes; BadInput for a value other than true and false."""
    for name, table in tables.items():
        if not isinstance(table.get(MUTE, False), bool):
            raise BadInput(f"mute of '{name}'", where=text.place(name, [MUTE]), right="true or false")
    return {name for name, table in tables.items() if table.get(MUTE)}


def passed_by(nodes: Mapping[str, Node], muted: set[str]) -> dict[str, Node]:
    """Return the other nodes: an edge from a muted node begins where its first input of the same type does.

    An optional input of a type that the muted node does not take is not connected then; pure.
    """
    kept = {}
    for node in nodes.values():
        if node.name not in muted:
            edges = {plug: resolved(node, plug, edge, nodes, muted) for plug, edge in node.edges.items()}
            kept[node.name] = replace(node, edges={plug: edge for plug, edge in edges.items() if edge is not None})
    return kept


def resolved(node: Node, plug: str, edge: Edge, nodes: Mapping[str, Node], muted: set[str]) -> Edge | None:
    """Follow an edge through muted nodes; None where nothing passes."""
    kind = node.type.socket(plug).type
    seen = set[str]()
    while edge.node in muted and edge.node not in seen:
        seen.add(edge.node)
        source = nodes[edge.node]
        fitting = [found for name, found in source.edges.items() if source.type.socket(name).type is kind]
        if not fitting:
            return None
        edge = fitting[0]
    return edge
