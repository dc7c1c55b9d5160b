"""Simplifications of `simulate_hair` for `hairpipe tune`, see `hairpipe/values/simplification.py`."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from hairpipe.values.simplification import Simplification

MODELS = {
    "network": {"rod": "elastic rods, not networks", "chain": "plain chain, no torsion"},
    "rod": {"network": "networks of springs, not rods", "chain": "plain chain, no torsion"},
    "chain": {},
}
"""Strand models that can take the place of another: none has less in it than a chain."""
PAIRS = (("collisions", "no collisions between hairs"), ("stiction", "no stiction"))
"""Groups of settings for which pairs of hairs are looked at."""
GROUPS = (*PAIRS, ("volume", "no volume of hair"))
"""Groups of settings whose physics can be left out, by which hair acts on hair."""
CELL = 0.006
"""Cell of the grid in place of pairs [m]."""
LOCKS = (4, 16)
"""Hairs in a lock, at most."""
COMPATIBLE_WITH_LOCKS = ("model", "precision", "segments", "steps", "voxels", "collisions", "keys")
"""Axes to which locks can be added, as they need contact pair by pair."""
PARTICLES = (2000, 500)
"""So many particles are simulated in place of at least as many strands."""
PRESCRIBED = {"ends", "target"}
"""Sockets that strands have and particles do not."""
SHARED = ("gravity", "wind", "checkpoint")
"""Settings that a simulation of particles has in common with one of strands."""
AROUND = ("body", "surface", "parts")
"""Sockets that both have."""

Settings = Mapping[str, Any]


def simplifications(settings: Settings, sockets: Collection[str], dt: float) -> Iterator[Simplification]:
    """List what can be left out of a simulation of strands, axis by axis."""
    # The node reports what another model does not support, such as curls of a chain.
    for level, (model, text) in enumerate(MODELS[settings["model"]].items(), 1):
        yield Simplification("model", level, text, (("model", model),))
    if settings["precision"] == "double":
        yield Simplification("precision", 1, "single precision where it is safe", (("precision", "automatic"),))
    for group, text in GROUPS:
        if settings[group] is not None:
            yield Simplification(group, 1, text, drops=(group,))
    pairs = tuple(group for group, _ in PAIRS if settings[group] is not None)
    if pairs and settings["volume"] is None:
        yield Simplification("pairs", 1, "hair as a volume, not pairs", (("volume.cell", CELL),), pairs)
    yield from of_locks(settings, sockets)
    if settings["gravity"] and not PRESCRIBED & set(sockets):  # Particles are led by a body alone, and weigh something.
        instead = f"{__name__}:{deformed_by_particles.__name__}"
        for level, count in enumerate(PARTICLES, 1):
            text = f"{count:,} particles, not strands"
            yield Simplification("particles", level, text, instead=instead, count=count, compatible=("voxels",))


def couples(settings: Settings) -> bool:
    """Return whether hair acts on hair."""
    return any(settings[group] is not None for group, _ in GROUPS)


def of_locks(settings: Settings, sockets: Collection[str]) -> Iterator[Simplification]:
    """Simulate once what sticks together, where pairs are in the solve and tips are free."""
    stiction, collisions = settings["stiction"], settings["collisions"]
    swept = collisions is not None and collisions["solver"] == "sweep"
    others = settings["volume"] is not None or settings["locks"] is not None
    if stiction is not None and not (swept or others or "ends" in sockets):
        for level, most in enumerate(LOCKS, 1):
            puts = (("locks.most", most),)
            yield Simplification("locks", level, f"locks of up to {most} hairs", puts, compatible=COMPATIBLE_WITH_LOCKS)


def deformed_by_particles(name: str, table: dict[str, Any], whole: str, part: Simplification) -> dict[str, Any]:
    """Make the nodes that simulate particles, which deform the hair, in place of a simulation of strands; pure."""
    particles = f"{name}-particles"
    cloud = f"{name}-cloud"
    material = _numbers(table.get("material", {}))
    around = {socket: edge for socket, edge in table["in"].items() if socket in AROUND}
    fibre = {"fibre": {key: material[key] for key in ("diameter", "density") if key in material}}
    moved = {"type": "simulate_particles", "in": {"particles": particles} | around} | fibre
    moved |= {key: table[key] for key in SHARED if key in table}
    moved |= {"air": _numbers(table["air"])} if "air" in table else {}
    moved |= {"sag_free": {}} if table.get("rest", {}).get("balanced") else {}
    moved |= {"interaction": {}} if any(group in table for group, _ in GROUPS) else {}
    friction = table.get("contact", {}).get("friction")
    moved |= {"contact": {"friction": friction}} if friction is not None else {}
    inputs = {"cloud": cloud, "particles": particles, "groom": table["in"]["groom"]}
    deformed = {"type": "carry_strands", "in": inputs | around}
    deformed |= {"diameter": material["diameter"]} if "diameter" in material else {}
    sampled = {"type": "sample_particles", "in": {"groom": whole}, "particles": part.count} | fibre
    return {particles: sampled, cloud: moved, name: deformed}


def _numbers(group: dict[str, Any]) -> dict[str, Any]:
    """Return the settings of a group as numbers, without variation, which particles do not have; pure."""
    numbers = {key: of.get("value") if isinstance(of, dict) else of for key, of in group.items()}
    return {key: number for key, number in numbers.items() if number is not None}
