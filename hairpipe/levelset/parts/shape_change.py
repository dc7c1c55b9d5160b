"""By how much parts change their shape from one frame to the next."""

import numpy as np
from numba import njit

from hairpipe.levelset.grid_layout import BRICK
from hairpipe.levelset.parts.field import FAR_OUTSIDE, PartField


@njit(cache=True)
def largest_changes(before: PartField, after: PartField, changes: np.ndarray) -> np.ndarray:
    """Return by how much the distance to every part changes at most over the frame, in its own frame [m], (G,); pure.

    What is deeper inside than the band is taken as its border: there the nearest way out may jump.

    changes  whether it does, (G,)
    """
    found = np.zeros(len(changes))
    for part in np.flatnonzero(changes):
        found[part] = max(largest_change(before, after, part), largest_change(after, before, part))
    return found


@njit(cache=True)
def largest_change(one: PartField, other: PartField, part: int) -> float:
    """Return the same over the bricks that a part has at one frame; those of two frames coincide."""
    largest, (na, nb, nc), width = 0.0, one.shapes[part], np.float32(one.background)
    ahead = np.rint((one.origins[part] - other.origins[part]) * one.per_metre / BRICK).astype(np.int64)
    for i, j, k in np.ndindex(na, nb, nc):
        n = one.bricks[one.starts[part] + (i * nb + j) * nc + k]
        if n >= 0:
            m = brick_of(other, part, i + ahead[0], j + ahead[1], k + ahead[2])
            if m >= 0:
                change = np.abs(np.maximum(other.distance[m], -width) - np.maximum(one.distance[n], -width)).max()
            else:
                far = other.background if m == FAR_OUTSIDE else -other.background
                change = np.abs(far - np.maximum(one.distance[n], -width)).max()
            largest = max(largest, change)
    return largest


@njit(cache=True)
def brick_of(field: PartField, part: int, i: int, j: int, k: int) -> int:
    """Return the index of the brick of a part at a block of space, FAR_OUTSIDE or FAR_INSIDE where there is none."""
    na, nb, nc = field.shapes[part]
    if 0 <= i < na and 0 <= j < nb and 0 <= k < nc:
        return field.bricks[field.starts[part] + (i * nb + j) * nc + k]
    return FAR_OUTSIDE
