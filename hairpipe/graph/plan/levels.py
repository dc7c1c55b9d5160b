"""Levels of a shot: groups of nodes that are computed in sequence; each is divided among machines.

once       values for the shot without inputs per frame
frames-1   values per frame without a scan before them
scans-1    scans, each on one machine
frames-2   values per frame that depend on those, and so on
collect    nodes that depend on all frames
"""

from typing import Literal, NamedTuple

from hairpipe.graph.file.graph import Graph
from hairpipe.graph.plan.portion import collectors

COLLECT = "collect"
ORDER = ("once", "each", "scan")
"""Modes of nodes in the order in which they are computed."""
Divided = Literal["no", "nodes", "frames"]
DIVIDED: dict[str, tuple[Divided, str]] = {
    "once": ("no", "once"),
    "each": ("frames", "frames"),
    "scan": ("nodes", "scans"),
}
"""Division and name of a level by the mode of its nodes."""


class Level(NamedTuple):
    """Nodes that can be computed concurrently after the previous levels.

    nodes    without consumers in this level
    divided  by node, by frame, or not at all
    """

    name: str
    nodes: tuple[str, ...]
    divided: Divided


def levels_of(graph: Graph) -> list[Level]:
    """List the levels of a graph in order."""
    late = set(collectors(graph))
    scans: dict[str, int] = {}
    groups: dict[tuple[int, int], list[str]] = {}
    for name, node in graph.nodes.items():
        sources = [edge.node for edge in node.edges.values()]
        if late.intersection(sources):
            late.add(name)
        scans[name] = max([scans[other] + (graph.nodes[other].type.mode == "scan") for other in sources], default=0)
        if name not in late:
            groups.setdefault((scans[name], ORDER.index(node.type.mode)), []).append(name)
    found = []
    for (number, place), names in sorted(groups.items()):
        needed = {edge.node for name in names for edge in graph.nodes[name].edges.values()}
        divided, label = DIVIDED[ORDER[place]]
        ends = tuple(name for name in names if divided == "nodes" or name not in needed)
        found.append(Level(label if divided == "no" else f"{label}-{number + 1}", ends, divided))
    return [*found, Level(COLLECT, (), "no")] if late else found
