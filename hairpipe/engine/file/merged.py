"""One graph of several variants, in which equal nodes occur once."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import Any

from hairpipe.engine.file.graph import Edge, Graph, Node
from hairpipe.engine.store.digest import canonical

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


def unvaried(graph: Graph, base: Graph, varied: Collection[str]) -> Graph:
    """Return a variant in which the unvaried sockets of its nodes are connected to results of the graph file. Pure.

    Nodes of the graph file whose results the variants change are added for them, as `node[unvaried]`.

    base    the graph file
    varied  names of the nodes with varied settings
    """
    changed = set(varied)
    for node in base.nodes.values():  # in dependency order
        if any(edge.node in changed for edge in node.edges.values()):
            changed.add(node.name)
    fixed = {
        (node.name, plug): edge.node
        for node in base.nodes.values()
        for plug, edge in node.edges.items()
        if node.type.socket(plug).name in node.type.unvaried and edge.node in changed
    }
    if not fixed:
        return graph
    names = {name: f"{name}{BEGIN}unvaried{END}" for name in base.upto(fixed.values()).nodes if name in changed}
    nodes: dict[str, Node] = {}
    for name, node in graph.nodes.items():
        nodes[name] = replace(
            node,
            edges={plug: moved(edge, names) if (name, plug) in fixed else edge for plug, edge in node.edges.items()},
        )
        if name in names:
            own = base.nodes[name]
            edges = {plug: moved(edge, names) for plug, edge in own.edges.items()}
            nodes[names[name]] = replace(own, name=names[name], edges=edges, publish=None)
    return replace(graph, nodes=nodes, taken=frozenset(e for node in nodes.values() for e in node.edges.values()))


def moved(edge: Edge, names: Mapping[str, str]) -> Edge:
    """Return an edge from the node that has another name, if it has one."""
    return Edge(names.get(edge.node, edge.node), edge.output)


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
