"""Simplifications that `tune` measures: those that a model of hair lists, and those common to all models.

A model is a scan node with an input Groom `groom` and an output Strands `strands`. Other inputs have the same name in
all models: bodies at `body`, ends of strands at `ends`, level sets anywhere; the settings of its steps are in a group
`steps`, with the longest one as `longest` [s]. No model is named here: see `hairpipe/values/simplification.py` for how
a model lists its own.
"""

import importlib
import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from hairpipe.app.api.shot import Graph, Node
from hairpipe.errors import BadInput
from hairpipe.values import BodyParts, Groom, LevelSet, Strands
from hairpipe.values.simplification import Puts, Simplification

SEGMENTS = (0.75, 0.5, 0.33)  # shares of the segments
FEWEST_SEGMENTS = 3
USUAL_LENGTHS = {"grow_groom": 0.005, "make_strands": 0.006}
"""Default lengths of segments by node type [m]: of 30 cm of straight hair."""
STEPS = (2.0, 4.0, 8.0)  # factors on the lengths that bound a step
FARTHEST = 1e3  # largest displacement in a step that a graph can set [m]
VOXELS = (1.5, 2.0, 3.0)  # factors on the spacing of level sets
LARGEST_VOXEL = 0.1  # [m]
KEYS = (4, 8)  # numbers of strands per key strand
BODIES = (LevelSet, BodyParts)  # types of sockets that take level sets
OUTPUT = "strands"
ORDER = ("model", "precision", "segments", "steps", "voxels", "*", "keys", "particles")
"""Axes in the order of measurement; the star is the place of axes that are not listed."""


def simplifications(graph: Graph, name: str) -> list[Simplification]:
    """List the simplifications of a simulation, axis by axis; BadInput for another node."""
    node = model_in(graph, name)
    found = [*of_node(graph, node), *of_segments(graph, node), *of_steps(graph, node), *of_voxels(graph, node)]
    if touches(node):  # a sample has neighbouring strands
        keys = enumerate(KEYS, 1)
        found += [Simplification("keys", n, f"one hair in {every} simulated", keys=every) for n, every in keys]
    return sorted(found, key=lambda part: ORDER.index(part.axis if part.axis in ORDER else "*"))


def model_in(graph: Graph, name: str) -> Node:
    """Return the node of that name, which simulates hair; BadInput for another one."""
    node = graph.node(name)
    if not is_model(node):
        known = ", ".join(f"--node {other.name}" for other in graph.nodes.values() if is_model(other))
        what = f"'{name}' is a {node.type.name}, which does not simulate hair"
        right = f"a graph with a node that takes a Groom and gives Strands and a state, at `{OUTPUT}` and `state`"
        raise BadInput(what, where=graph.path, right=known or right)
    return node


def is_model(node: Node) -> bool:
    sockets, outputs = node.type.sockets, node.type.outputs
    groom = sockets.get("groom")
    return node.type.mode == "scan" and groom is not None and groom.type is Groom and outputs.get(OUTPUT) is Strands


def declared(node: Node, function: str) -> Any:
    """Find a function of the tuning module of a node type; None without one."""
    return getattr(importlib.import_module(node.type.tuning), function, None) if node.type.tuning else None


def touches(node: Node) -> bool:
    """Return whether hair acts on hair in a simulation."""
    couples = declared(node, "couples")
    return bool(couples and couples(node.settings))


def of_node(graph: Graph, node: Node) -> Iterator[Simplification]:
    """List those of the model itself; another model replaces it only if all other nodes use nothing but its strands."""
    listed = declared(node, "simplifications")
    sockets = {plug.partition(".")[0] for plug in node.edges}
    taken = any(edge.node == node.name and edge.output != OUTPUT for _, _, edge in graph.consumers())
    for part in listed(node.settings, sockets, 1.0 / graph.fps) if listed else ():
        puts = tuple((f"{node.name}.{target}", value) for target, value in part.puts)
        if not (part.instead and taken):
            yield replace(part, puts=puts, drops=tuple(f"{node.name}.{target}" for target in part.drops))


def of_segments(graph: Graph, node: Node) -> Iterator[Simplification]:
    """Use fewer or longer segments, where nodes of the groom have settings for it."""
    behind = [maker for maker in above(graph, node.edges["groom"].node) if "segment_length" in maker.settings]
    counts = {maker.name: maker.settings["segments"] for maker in behind if maker.settings["segments"]}
    lengths = {
        maker.name: maker.settings["segment_length"] or USUAL_LENGTHS[maker.type.name]
        for maker in behind
        if maker.name not in counts and (maker.settings["segment_length"] or maker.type.name in USUAL_LENGTHS)
    }
    fewest = min(counts.values(), default=FEWEST_SEGMENTS / SEGMENTS[-1] if lengths else 0)
    for level, share in enumerate((share for share in SEGMENTS if round(fewest * share) >= FEWEST_SEGMENTS), 1):
        fewer = {name: round(count * share) for name, count in counts.items()}
        longer = {name: float(f"{length / share:.6g}") for name, length in lengths.items()}
        texts = [f"{listed(fewer.values())} segments, not {listed(counts.values())}"] if fewer else []
        texts += [f"segments of {listed(longer.values())} m"] if longer else []
        changed = [(f"{name}.segments", n) for name, n in fewer.items()]
        changed += [(f"{name}.segment_length", length) for name, length in longer.items()]
        yield Simplification("segments", level, "; ".join(texts), tuple(changed))


def of_steps(graph: Graph, node: Node) -> Iterator[Simplification]:
    longest = steps_of(node).get("longest", math.inf)
    for level, factor in enumerate(STEPS, 1):
        if longest * factor / STEPS[0] < 1.0 / graph.fps:
            changed = scaled_steps(node, factor, most=1.0 / graph.fps)
            yield Simplification("steps", level, f"steps up to 1/{1.0 / changed[0][1]:.0f} s", changed)


def steps_of(node: Node) -> dict[str, float]:
    steps = node.settings.get("steps")
    bounds = ("longest", "root", "travel", "strain_rate", "courant")
    return {name: steps[name] for name in bounds if steps.get(name) is not None} if isinstance(steps, dict) else {}


def scaled_steps(node: Node, factor: float, most: float = 1.0) -> Puts:
    """Scale the bounds of a step: `longest` [s] up to `most`, `root` and `travel` [m] up to the largest setting."""
    limits = {"longest": most, "root": FARTHEST, "travel": FARTHEST}
    scaled = {name: min(value * factor, limits.get(name, math.inf)) for name, value in steps_of(node).items()}
    return tuple((f"{node.name}.steps.{name}", float(f"{value:.6g}")) for name, value in scaled.items())


def of_voxels(graph: Graph, node: Node) -> Iterator[Simplification]:
    """Sample the space around bodies more coarsely."""
    makers = {name: graph.nodes[name] for name in levelsets_of(node)}
    voxels = {name: maker.settings["voxel"] for name, maker in makers.items() if "voxel" in maker.settings}
    for level, factor in enumerate(VOXELS, 1):
        puts = tuple((f"{name}.voxel", float(f"{voxel * factor:.4g}")) for name, voxel in voxels.items())
        if puts and max(value for _, value in puts) <= LARGEST_VOXEL:
            text = "voxels of " + ", ".join(f"{1e3 * value:g} mm" for _, value in puts)
            yield Simplification("voxels", level, text, puts)


def levelsets_of(node: Node) -> list[str]:
    """List the nodes that compute the level sets around a simulation."""
    return [edge.node for plug, edge in node.edges.items() if node.type.socket(plug).type in BODIES]


def listed(counts: Iterable[float]) -> str:
    return ", ".join(str(count) for count in dict.fromkeys(counts))


def above(graph: Graph, name: str) -> Iterator[Node]:
    """Iterate over a node and its inputs, the nearest first."""
    queue = [name]
    seen = {name}
    while queue:
        node = graph.nodes[queue.pop(0)]
        yield node
        behind = [edge.node for edge in node.edges.values() if edge.node not in seen]
        seen.update(behind)
        queue += behind
