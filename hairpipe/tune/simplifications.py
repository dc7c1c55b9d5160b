"""Simplifications of a simulation of hair, as data: settings of the graph with less physics, or coarser."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from hairpipe.api.shot import Graph, Node
from hairpipe.errors import BadInput

SEGMENTS = (0.75, 0.5, 0.33)
"""Shares of the segments."""
FEWEST_SEGMENTS = 3
USUAL_LENGTHS = {"grow_groom": 0.005, "make_strands": 0.006}
"""Default lengths of segments by node type [m]: of 30 cm of straight hair."""
STEPS = (2.0, 4.0, 8.0)
"""Factors on the lengths that bound a step."""
FARTHEST = 1e3
"""The largest way in a step that a graph can state [m]."""
VOXELS = (1.5, 2.0, 3.0)
"""Factors on the spacing of level sets."""
LARGEST_VOXEL = 0.1  # [m]
PAIRS = (("collisions", "no collisions between hairs"), ("stiction", "no stiction"))
"""Groups of settings for which pairs of hairs are looked at."""
GROUPS = (*PAIRS, ("volume", "no volume of hair"))
"""Groups of settings whose physics can be left out, by which hair acts on hair."""
CELL = 0.006
"""Of the grid that takes the place of pairs [m]."""
LOCKS = (4, 16)
"""Hairs in a lock, at most."""
LOCKED_BESIDE = ("model", "precision", "segments", "steps", "voxels", "collisions", "keys")
"""Axes beside which hair can be in locks, for which it must stick pair by pair."""
KEYS = (4, 8)
"""So many strands one is simulated, the others are interpolated."""
PARTICLES = (2000, 500)
"""So many particles are simulated in place of at least as many strands."""
LED = ("ends", "target")
"""Sockets of the simulation that lead strands, and do not lead particles."""
BODIES = ("surface", "parts")
"""Sockets of the simulation that take level sets."""
TYPE = "simulate_hair"


@dataclass(frozen=True)
class Simplification:
    """One part of the physics left out, or one discretisation made coarser.

    axis       what it is about; of each axis one simplification at most can be taken
    level      how far it goes on this axis: a higher one leaves out more
    text       what it does, in words
    puts       settings by target `node.setting`, with their values
    drops      targets of groups that are taken out
    keys       one in how many strands is simulated; 1: all
    particles  simulated in place of strands; 0: strands are
    beside     axes of which something can be left out beside it; None: of all
    """

    axis: str
    level: int
    text: str
    puts: tuple[tuple[str, Any], ...] = ()
    drops: tuple[str, ...] = ()
    keys: int = 1
    particles: int = 0
    beside: tuple[str, ...] | None = None


def simplifications(graph: Graph, name: str) -> list[Simplification]:
    """List what can be left out of a simulation, axis by axis; BadInput where the node is none."""
    node = graph.node(name)
    if node.type.name != TYPE:
        known = ", ".join(f"--node {other.name}" for other in graph.nodes.values() if other.type.name == TYPE)
        what = f"'{name}' is a {node.type.name}, which has nothing to leave out"
        raise BadInput(what, where=graph.path, right=known or f"a graph with a node of type {TYPE}")
    shortened = [*of_segments(graph, node), *of_steps(graph, node), *of_voxels(graph, node)]
    others = [*of_groups(node), *of_pairs(node), *of_locks(node), *of_keys(node), *of_particles(graph, node)]
    return [*of_model(node), *of_precision(node), *shortened, *others]


def touches(node: Node) -> bool:
    """Tell whether hair acts on hair in a simulation."""
    return any(node.settings[group] is not None for group, _ in GROUPS)


def of_model(node: Node) -> Iterator[Simplification]:
    """Leave out torsion and the particles off the axis."""
    if node.settings["model"] == "network":
        yield Simplification("model", 1, "plain chain, no torsion", ((f"{node.name}.model", "chain"),))


def of_precision(node: Node) -> Iterator[Simplification]:
    """Use single precision where that is safe."""
    if node.settings["precision"] == "double":
        text = "single precision where it is safe"
        yield Simplification("precision", 1, text, ((f"{node.name}.precision", "automatic"),))


def of_segments(graph: Graph, node: Node) -> Iterator[Simplification]:
    """Cut hair into fewer segments, or longer ones, where its grooms come from nodes that have settings for it."""
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
    """Take longer steps, up to a frame."""
    longest = node.settings["steps"]["longest"]
    for level, factor in enumerate(STEPS, 1):
        if longest * factor / STEPS[0] < 1.0 / graph.fps:
            changed = scaled_steps(node, factor, most=1.0 / graph.fps)
            yield Simplification("steps", level, f"steps up to 1/{1.0 / changed[0][1]:.0f} s", changed)


def scaled_steps(node: Node, factor: float, most: float = 1.0) -> tuple[tuple[str, float], ...]:
    """Scale what bounds a step: `longest` [s] up to `most`, `root` and `travel` [m] up to what a graph can state."""
    steps = node.settings["steps"]
    values = {"longest": min(steps["longest"] * factor, most)}
    values |= {name: min(steps[name] * factor, FARTHEST) for name in ("root", "travel")}
    values |= {name: steps[name] * factor for name in ("strain_rate", "courant") if steps[name] is not None}
    return tuple((f"{node.name}.steps.{name}", float(f"{value:.6g}")) for name, value in values.items())


def of_voxels(graph: Graph, node: Node) -> Iterator[Simplification]:
    """Sample the space around bodies more coarsely."""
    makers = {edge.node: graph.nodes[edge.node] for plug, edge in node.edges.items() if plug.split(".")[0] in BODIES}
    voxels = {name: maker.settings["voxel"] for name, maker in makers.items() if "voxel" in maker.settings}
    for level, factor in enumerate(VOXELS, 1):
        puts = tuple((f"{name}.voxel", float(f"{voxel * factor:.4g}")) for name, voxel in voxels.items())
        if puts and max(value for _, value in puts) <= LARGEST_VOXEL:
            text = "voxels of " + ", ".join(f"{1e3 * value:g} mm" for _, value in puts)
            yield Simplification("voxels", level, text, puts)


def of_groups(node: Node) -> Iterator[Simplification]:
    """Leave physics out that is an optional group of settings."""
    for group, text in GROUPS:
        if node.settings[group] is not None:
            yield Simplification(group, 1, text, drops=(f"{node.name}.{group}",))


def of_pairs(node: Node) -> Iterator[Simplification]:
    """Take hair as a volume in place of pairs of hairs."""
    pairs = tuple(f"{node.name}.{group}" for group, _ in PAIRS if node.settings[group] is not None)
    if pairs and node.settings["volume"] is None:
        yield Simplification("pairs", 1, "hair as a volume, not pairs", ((f"{node.name}.volume.cell", CELL),), pairs)


def of_locks(node: Node) -> Iterator[Simplification]:
    """Simulate once what sticks together, where pairs are in the solve and tips are free."""
    stiction, collisions = node.settings["stiction"], node.settings["collisions"]
    swept = collisions is not None and collisions["solver"] == "sweep"
    others = node.settings["volume"] is not None or node.settings["locks"] is not None
    if stiction is not None and not (swept or others or "ends" in node.edges):
        for level, most in enumerate(LOCKS, 1):
            text, puts = f"locks of up to {most} hairs", ((f"{node.name}.locks.most", most),)
            yield Simplification("locks", level, text, puts, beside=LOCKED_BESIDE)


def of_keys(node: Node) -> Iterator[Simplification]:
    """Simulate key hairs and interpolate the others, where a sample has strands beside each other."""
    if touches(node):
        for level, every in enumerate(KEYS, 1):
            yield Simplification("keys", level, f"one hair in {every} simulated", keys=every)


def of_particles(graph: Graph, node: Node) -> Iterator[Simplification]:
    """Simulate particles in place of strands, where these are led by a body alone and no node takes their state."""
    led = any(plug.split(".")[0] in LED for plug in node.edges)
    taken = any(tuple(edge) == (node.name, "state") for other in graph.nodes.values() for edge in other.edges.values())
    for level, count in enumerate(() if led or taken or not node.settings["gravity"] else PARTICLES, 1):
        text = f"{count:,} particles, not strands"
        yield Simplification("particles", level, text, particles=count, beside=("voxels",))


def listed(counts: Iterable[float]) -> str:
    """Write counts, equal ones once."""
    return ", ".join(str(count) for count in dict.fromkeys(counts))


def above(graph: Graph, name: str) -> Iterator[Node]:
    """Iterate over a node and those behind it, the nearest first."""
    queue, seen = [name], {name}
    while queue:
        node = graph.nodes[queue.pop(0)]
        yield node
        behind = [edge.node for edge in node.edges.values() if edge.node not in seen]
        seen.update(behind)
        queue += behind
