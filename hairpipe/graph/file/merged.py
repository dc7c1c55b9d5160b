"""One graph of several variants, in which equal nodes occur once."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from hairpipe.graph.file.graph import Edge, Graph, Node
from hairpipe.graph.store.digest import canonical

BEGIN, END = "[", "]"
"""Delimiters of the label of a variant; names of nodes in a graph file do not contain them."""


def merged(
    variants: Mapping[str, Graph], name_of: Callable[[list[str]], str]
) -> tuple[Graph, dict[str, dict[str, str]]]:
    """Merge graphs with the same nodes and different settings; keys of results do not change. Pure.

    Returns the graph, and the names of its nodes by variant. Nodes that are equal in all variants keep their names and
    their paths of publication; others are named `node[name]` and published in a subfolder `name`.

    name_of  returns the name of a group of variants
    """
    first = next(iter(variants.values()))
    names: dict[str, dict[str, str]] = {label: {} for label in variants}
    nodes: dict[str, Node] = {}
    for name in first.nodes:
        alike: dict[str, list[str]] = {}
        for label, graph in variants.items():
            alike.setdefault(identity(graph.nodes[name], names[label]), []).append(label)
        for labels in alike.values():
            node = renamed(
                variants[labels[0]].nodes[name], names[labels[0]], "" if len(alike) == 1 else name_of(labels)
            )
            nodes[node.name] = node
            for label in labels:
                names[label][name] = node.name
    taken = frozenset(Edge(own[edge.node], edge.output) for own in names.values() for edge in first.taken)
    return replace(first, nodes=nodes, taken=taken), names


def origin(name: str) -> str:
    """Return the name, in the graph file, of a node of a merged graph."""
    return name.partition(BEGIN)[0]


def identity(node: Node, names: Mapping[str, str]) -> str:
    """Return the edges and settings of a node as text.

    names  in the merged graph, of the nodes before it
    """
    edges: dict[str, Any] = {plug: [names[edge.node], edge.output] for plug, edge in node.edges.items()}
    return canonical({"edges": edges, "settings": node.settings})


def renamed(node: Node, names: Mapping[str, str], label: str) -> Node:
    """Return a node with the names of the merged graph, also in its edges."""
    edges = {plug: Edge(names[edge.node], edge.output) for plug, edge in node.edges.items()}
    if not label:
        return replace(node, edges=edges)
    publish = node.publish and node.publish.parent / label / node.publish.name
    return replace(node, name=f"{node.name}{BEGIN}{label}{END}", edges=edges, publish=publish)
