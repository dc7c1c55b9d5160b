"""Levels of a shot, which are computed in sequence; each is divided among machines.

once       values for the shot without inputs per frame
frames-1   values per frame without a scan before them
scans-1    scans, each on one machine
frames-2   values per frame that depend on those, and so on
collect    nodes that depend on all frames

In a wedge, what all variants share comes first: `once-variants`, `frames-1-variants` and `collect-variants` are divided
among variants.
"""

from typing import NamedTuple

from hairpipe.engine.file.graph import Graph
from hairpipe.engine.file.merged import BEGIN
from hairpipe.engine.plan.portion import collectors

COLLECT = "collect"
VARIANTS = "-variants"
ORDER = ("once", "each", "scan")
"""Modes of nodes in the order in which they are computed."""
NAMES = {"once": "once", "each": "frames", "scan": "scans"}
"""Name of a level by the mode of its nodes."""


class Level(NamedTuple):
    """Nodes that can be computed after the previous levels.

    groups    nodes without consumers in this level, in groups that can be computed concurrently; none: all nodes
    by_frame  whether frames can be computed concurrently, too
    """

    name: str
    groups: tuple[tuple[str, ...], ...]
    by_frame: bool


def levels_of(graph: Graph) -> list[Level]:
    """List the levels of a graph in order."""
    late = set(collectors(graph))
    scans: dict[str, int] = {}
    found: dict[tuple[int, int, bool], list[str]] = {}
    for name, node in graph.nodes.items():
        sources = [edge.node for edge in node.edges.values()]
        if late.intersection(sources):
            late.add(name)
        scans[name] = max([scans[other] + (graph.nodes[other].type.mode == "scan") for other in sources], default=0)
        if name not in late:
            mode = node.type.mode
            found.setdefault((scans[name], ORDER.index(mode), mode != "scan" and _varies(name)), []).append(name)
    levels = []
    for (number, place, varies), names in sorted(found.items()):
        mode = ORDER[place]
        name = NAMES[mode] + (f"-{number + 1}" if mode != "once" else "") + (VARIANTS if varies else "")
        groups = tuple((name,) for name in names) if mode == "scan" else _by_variant(_ends(graph, names))
        levels.append(Level(name, groups, mode == "each"))
    if ends := _ends(graph, [name for name in graph.nodes if name in late and _varies(name)]):
        levels.append(Level(COLLECT + VARIANTS, _by_variant(ends), False))
    return [*levels, Level(COLLECT, (), False)] if late else levels


def _varies(name: str) -> bool:
    """Whether a node of a wedge is of some variants only."""
    return BEGIN in name


def _ends(graph: Graph, names: list[str]) -> list[str]:
    """Return the nodes of a level without consumers in it."""
    needed = {edge.node for name in names for edge in graph.nodes[name].edges.values()}
    return [name for name in names if name not in needed]


def _by_variant(names: list[str]) -> tuple[tuple[str, ...], ...]:
    """Group nodes by the variants that have them."""
    groups: dict[str, list[str]] = {}
    for name in names:
        groups.setdefault(name.partition(BEGIN)[2], []).append(name)
    return tuple(map(tuple, groups.values()))
