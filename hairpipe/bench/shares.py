"""Where the time of a frame goes: seconds by part of the work, from a profile of the Python that calls the kernels."""

import cProfile
import pstats
from collections.abc import Callable
from pathlib import Path

PARTS = ("strands", "search", "stiction", "coupling", "collision", "body")
"""Strand solver, search for neighbours, upkeep of stiction, the solve that couples strands, collisions, bodies."""
_OF_CONTACT = {
    "body": ("body", "hold", "project", "folds"),
    "stiction": ("stiction", "ignored", "pairs"),
    "coupling": ("couplings", "conjugate", "repulsion", "contacts"),
    "search": ("near", "nearest", "swept", "grid", "pieces", "found", "distances", "drift"),
    "collision": ("collision", "crossings", "coplanar", "encounter", "grazing", "crossing_normal", "sweep"),
}


def shares_of(work: Callable[[], object]) -> dict[str, float]:
    """Do some work; return the seconds of every part of it. A kernel counts for the file that calls it."""
    profile = cProfile.Profile()
    profile.runcall(work)
    seconds = dict.fromkeys(PARTS, 0.0)
    for (path, _, name), (_, _, own, _, _) in pstats.Stats(profile).stats.items():  # type: ignore[attr-defined]
        seconds[part_of(Path(path), name)] += own
    return seconds


def part_of(path: Path, function: str) -> str:
    """Name the part that a function stands for."""
    if path.parent.name == "contact":
        return next((part for part, stems in _OF_CONTACT.items() if path.stem in stems), "coupling")
    if path.parent.name == "levelset":
        return "body"
    return "coupling" if function == "respond" else "strands"
