"""Time of a frame by part of the simulation, from a profile of the Python code that calls the kernels."""

import cProfile
import pstats
import time
from collections.abc import Callable
from pathlib import Path

import hairpipe

PARTS = ("strands", "search", "stiction", "coupling", "collision", "grid", "body")
"""Strands, neighbour search, update of stiction, coupled solve, collisions, volume, bodies."""
_ROOMS = {"levelset": "body", "volume": "grid"}
"""Rooms whose files belong to one part."""
_FILES = {
    "search": (
        *("geometry/proximity", "geometry/segment_distance", "geometry/segment_tree"),
        *("geometry/segments", "geometry/sorting"),
    ),
    "stiction": ("contact/stiction",),
    "coupling": (
        *("contact/contact_points", "contact/hair", "contact/repulsion"),
        *("solve/conjugate_gradients", "solve/couplings", "solve/surroundings"),
    ),
    "collision": ("contact/collision",),
    "body": ("contact/body", "contact/body_implicit", "contact/body_projection"),
}
_DEEPEST = 8
"""Calls outside of this package that are followed back: numpy's own are few."""
_HOUSE = Path(hairpipe.__file__).parent

Function = tuple[str, int, str]
Callers = dict[Function, tuple[int, int, float, float]]
Weights = dict[tuple[Function, int], dict[str, float]]


def part_of(path: Path) -> str:
    """Return the part of a file."""
    name = f"{path.parent.name}/{path.stem}"
    found = next((part for part, names in _FILES.items() if name in names), "strands")
    return _ROOMS.get(path.parent.name, found)


def shares_of(
    work: Callable[[], object],
    part_of: Callable[[Path], str] = part_of,
    parts: tuple[str, ...] = PARTS,
    clock: Callable[[], float] = time.perf_counter,
) -> tuple[float, dict[str, float]]:
    """Do some work; return its seconds and those of every part. What is not ours counts for the file that calls it.

    part_of  names the part that a file stands for
    parts    all of them
    clock    tells seconds
    """
    profile = cProfile.Profile(clock)
    begun = clock()
    profile.runcall(work)
    whole = clock() - begun
    stats = pstats.Stats(profile).stats  # type: ignore[attr-defined]
    seconds = dict.fromkeys(parts, 0.0)
    known: Weights = {}
    for function, (_, _, own, _, _) in stats.items():
        for caller, weight in _weights(function, stats, 0, known).items():
            seconds[part_of(Path(caller))] += weight * own
    return whole, seconds


def _weights(function: Function, stats: dict, depth: int, known: Weights) -> dict[str, float]:
    """Return the shares of a function's time by file of this package that called it, from the times of the calls.

    Shares are computed once for a function and depth: a compiler has thousands of functions that call each other, and
    the number of paths between them is exponential in the depth.
    """
    if (function, depth) not in known:
        callers: Callers = stats[function][4] if function in stats else {}
        found: dict[str, float] = {}
        if Path(function[0]).is_relative_to(_HOUSE) or not callers or depth == _DEEPEST:
            found[function[0]] = 1.0
            callers = {}
        total = sum(cumulative for _, _, _, cumulative in callers.values())
        for caller, (_, _, _, cumulative) in callers.items():
            weight = cumulative / total if total > 0.0 else 1.0 / len(callers)
            for file, share in _weights(caller, stats, depth + 1, known).items():
                found[file] = found.get(file, 0.0) + weight * share
        known[function, depth] = found
    return known[function, depth]
