"""One graph of several variants: what is the same in some is there once, the other nodes under names of their own."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from hairpipe.graph.file.graph import Edge, Graph, Node
from hairpipe.graph.store.digest import canonical

BEGIN, END = "[", "]"
"""Around what tells nodes of one name apart: no node of a graph file has them in its name."""


def merged(
    variants: Mapping[str, Graph], name_of: Callable[[list[str]], str]
) -> tuple[Graph, dict[str, dict[str, str]]]:
    """Merge graphs of the same nodes, whose settings differ; keys of results are those of each graph. Pure.

    Return the graph, and by variant the names of its nodes there. What is the same in all variants keeps its name, and
    is published where it was; anything else is `node[name]`, published in a folder `name` of its own there.

    name_of  names a group of variants after what they have in common
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
    """Name the node of the graph file behind a node of a merged graph."""
    return name.partition(BEGIN)[0]


def identity(node: Node, names: Mapping[str, str]) -> str:
    """Write down all that a node computes from.

    names  of the nodes before it, in the merged graph
    """
    edges: dict[str, Any] = {plug: [names[edge.node], edge.output] for plug, edge in node.edges.items()}
    return canonical({"edges": edges, "settings": node.settings})


def renamed(node: Node, names: Mapping[str, str], label: str) -> Node:
    """Return a node under its name in the merged graph; its edges, too."""
    edges = {plug: Edge(names[edge.node], edge.output) for plug, edge in node.edges.items()}
    if not label:
        return replace(node, edges=edges)
    publish = node.publish and node.publish.parent / label / node.publish.name
    return replace(node, name=f"{node.name}{BEGIN}{label}{END}", edges=edges, publish=publish)
