"""Chooses, of all shipped graphs, nodes that have every kind of node and of edge in them: a test computes these alone.

A kind of node is a type with the optional groups of settings that are given; a kind of edge is a type of value and the
socket that takes it.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path

from hairpipe.engine.file.graph import Graph, Node
from hairpipe.engine.node.settings import Field, fields_of

Place = tuple[Path, str]
"""A graph file, and one of its nodes."""


def cover(*stages: dict[Path, Graph]) -> dict[Path, list[str]]:
    """Choose nodes that, with all they depend on, have every kind in them; of later stages for what earlier ones lack.

    Greedily, by the number of new kinds for each node that has to be computed; nodes that are equal in several graphs
    count once. The first of those that are as good is taken.
    """
    kinds, known = Numbers(), Numbers()
    within: dict[Place, int] = {}  # sets as bits of whole numbers: the kinds in a node and all it depends on,
    needed: dict[Place, int] = {}  # and these nodes themselves
    for path, graph in (item for stage in stages for item in stage.items()):
        keys: dict[str, int] = {}
        for name, node in graph.nodes.items():  # after those it depends on
            inputs = [(plug, keys[edge.node], edge.output) for plug, edge in node.edges.items()]
            keys[name] = known.of((node.type.name, repr(node.settings), *inputs, graph.frames, graph.fps))
            above = [(path, edge.node) for edge in node.edges.values()]
            within[path, name] = bits(map(kinds.of, kinds_of(graph, node))) | union(within[place] for place in above)
            needed[path, name] = bits([keys[name]]) | union(needed[place] for place in above)
    found, computed, chosen = 0, 0, dict[Path, list[str]]()

    def worth(place: Place) -> float:
        return (within[place] & ~found).bit_count() / (1 + (needed[place] & ~computed).bit_count())

    for stage in stages:
        places = [(path, name) for path, graph in stage.items() for name in graph.nodes]
        while places and worth(best := max(places, key=worth)):
            found, computed = found | within[best], computed | needed[best]
            chosen.setdefault(best[0], []).append(best[1])
    return chosen


def kinds_of(graph: Graph, node: Node) -> Iterator[tuple]:
    """Name what kind a node is of, and its edges."""
    yield node.type.name, frozenset(groups_of(fields_of(node.type), node.settings))
    for plug, edge in node.edges.items():
        value = graph.nodes[edge.node].type.outputs[edge.output]
        yield value, node.type.name, plug.partition(".")[0]


def groups_of(fields: Iterable[Field], settings: dict, above: str = "") -> Iterator[str]:
    """Name the optional groups of settings that are given, as `group.group`."""
    for field in fields:
        value = settings[field.name]
        if field.group and value is not None:
            if field.optional:
                yield above + field.name
            yield from groups_of(field.group, value, f"{above}{field.name}.")


class Numbers(dict):
    """Numbers things in the order in which they are met."""

    def of(self, thing: object) -> int:
        """Give the number of a thing."""
        return self.setdefault(thing, len(self))


def bits(numbers: Iterable[int]) -> int:
    return union(1 << number for number in numbers)


def union(sets: Iterable[int]) -> int:
    result = 0
    for each in sets:
        result |= each
    return result
