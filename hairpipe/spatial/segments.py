"""The segments of strands, and the check that their points are finite."""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.vec3 import row

FARTHEST = 1e12
"""Coordinates beyond this [m] are refused."""

TOUCHING = 1e-6
"""Distance over the lengths of both segments."""


def all_segments(offsets: np.ndarray) -> np.ndarray:
    """List the segments of all strands, whose points are offsets[s] : offsets[s + 1], (m,) int32, ascending; pure."""
    counts = np.maximum(np.diff(offsets) - 1, 0)
    ends = np.cumsum(counts)
    segments = np.empty(counts.sum(), np.int32)
    _list(offsets, ends - counts, ends, segments)
    return segments


@njit(cache=True, parallel=True)
def _list(offsets, starts, ends, segments):
    for strand in prange(len(starts)):
        for k in range(starts[strand], ends[strand]):
            segments[k] = offsets[strand] + k - starts[strand]


class LostPoints(ArithmeticError):
    """Points, (n,) int64, are not finite, or farther away than a light-hour."""

    def __init__(self, points: np.ndarray) -> None:
        super().__init__(f"{len(points)} points of the hair are not finite, the first is number {points[0]}")
        self.points = points


def refuse_lost(points: np.ndarray) -> None:
    """Raise LostPoints where positions [m], (P, 3), are."""
    lost = np.empty(len(points), np.bool_)
    if _find_lost(points, lost):
        raise LostPoints(np.flatnonzero(lost))


@njit(cache=True, parallel=True)
def _find_lost(points, lost):
    """Mark what is lost, in place; return the number of marks."""
    count = 0
    for k in prange(len(points)):
        x, y, z = row(points, k)
        # max may drop a NaN, depending on the order of its arguments: each is tested for itself, too.
        lost[k] = not max(abs(x), max(abs(y), abs(z))) <= FARTHEST or x != x or y != y or z != z
        count += lost[k]
    return count
