"""Projection of strands out of a body without stretch: alternates between both constraints.

A point that was moved out may be too far from its neighbour towards the root. It is pulled towards that neighbour in
the plane of its contact, so that it slides along the body and not back into it; on a curved body it is then moved out
again. If that fails, as when a thin part of the body separates the two, it is placed next to the neighbour, on the
same side of the body. The neighbour is outside, so a valid place always exists.
"""

from collections.abc import Callable

import numpy as np
from numba import njit

from hairpipe.levelset.collider import SdfSample

STRETCH = 0.1
"""Largest stretch of a segment by a correction of its ends, over its length."""
_ROUNDS = 64  # of both; what is inside then cannot be helped
_PATIENCE = 4  # rounds until points are laid next to those before them
_SHORT = 0.5  # of what a point keeps from the body; nearer than that it is moved out again
_SHORTEST = 1e-4  # [m]; nothing that is nearer by less than this is moved again
_STEEPEST = 0.9  # of the longest way to a neighbour, that may be along the normal


def drape(
    after: np.ndarray,
    dx: np.ndarray,
    normals: np.ndarray,
    most: np.ndarray,
    masses: np.ndarray,
    look: Callable[[np.ndarray, np.ndarray], tuple[SdfSample, np.ndarray]],
    scale: float = 1.0,
) -> None:
    """Change dx, (P, 3) [m], in place, until it neither stretches a segment nor leaves a point inside.

    after    positions without dx, which moves them out [m], (P, 3)
    normals  directions of these motions, 0 for points not moved, (P, 3); in place
    most     largest distance from the body to which points are moved out [m], (P,)
    masses   [kg], (P,); inf if held, at roots
    look     finds the probe of the body at positions [m], (n, 3), of points (n,), and their contact distances [m],
             (n,)
    scale    of lengths [1], see `Scale`
    """
    moved = after + dx
    strands = np.cumsum(np.isinf(masses))
    wrong = np.ones(strands[-1] + 1, bool)
    for turn in range(_ROUNDS):
        keep_lengths(after, normals, masses, moved)
        looked = np.flatnonzero(wrong[strands])
        chosen = looked[(moved[looked] != after[looked]).any(axis=1)]
        probe, kept = look(moved[chosen], chosen)
        aim = np.minimum(kept, most[chosen])
        short = aim - probe.distance
        bad = (short > np.maximum(_SHORT * np.abs(aim), scale * _SHORTEST)) & probe.normal.any(axis=1)
        if not bad.any():
            break
        out = chosen[bad]
        wrong[:] = False
        wrong[strands[out]] = True
        if turn % _PATIENCE < _PATIENCE - 1:
            normals[out] = probe.normal[bad]
            moved[out] += short[bad, None] * probe.normal[bad]
        else:
            align_with_neighbours(out, normals, moved)
    else:
        keep_lengths(after, normals, masses, moved)
    dx[:] = moved - after


@njit(cache=True)
def keep_lengths(after: np.ndarray, normals: np.ndarray, masses: np.ndarray, moved: np.ndarray) -> None:
    """Pull points towards their predecessors, from the root on, where segments are stretched too far; moved in place.

    Arguments as for `drape`.
    """
    way = np.empty(3)
    for i in range(1, len(moved)):
        if masses[i] == np.inf:  # A root: the point before it belongs to another strand.
            continue
        rest = length = along = 0.0
        for a in range(3):
            way[a] = moved[i, a] - moved[i - 1, a]
            rest += (after[i, a] - after[i - 1, a]) ** 2
            length += way[a] ** 2
            along += way[a] * normals[i, a]
        longest = (1.0 + STRETCH) ** 2 * rest
        if length <= longest:
            continue
        # Along the normal alone it is nearly too long: the whole way is shortened, not only that in the plane.
        if along**2 > _STEEPEST**2 * longest:
            along = 0.0
        # Shortens the way within the plane of contact only, so that the point slides and is not pulled back in.
        scale = np.sqrt((longest - along**2) / (length - along**2))
        for a in range(3):
            up = along * normals[i, a]
            moved[i, a] = moved[i - 1, a] + up + scale * (way[a] - up)


@njit(cache=True)
def align_with_neighbours(which: np.ndarray, normals: np.ndarray, moved: np.ndarray) -> None:
    """Lay points, ascending, where the plane of contact of the ones before them is, else nearer to these; in place."""
    for i in which:
        down = 0.0
        for a in range(3):
            down += (moved[i, a] - moved[i - 1, a]) * normals[i - 1, a]
        for a in range(3):
            way = moved[i, a] - moved[i - 1, a]
            moved[i, a] = moved[i - 1, a] + (way - down * normals[i - 1, a] if down < 0.0 else 0.5 * way)
            normals[i, a] = normals[i - 1, a]
