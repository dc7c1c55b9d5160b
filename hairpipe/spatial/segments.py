"""The segments of strands, and the check that their points are finite."""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.vec3 import row

FARTHEST = 1e12
"""Coordinates beyond this [m] are refused."""

TOUCHING = 1e-6
"""Distance over the lengths of both segments."""


def all_segments(points: int, offsets: np.ndarray) -> np.ndarray:
    """List the segments of all strands of so many points, (m,) int32, ascending; pure."""
    is_segment = np.ones(points, bool)
    is_segment[offsets[1:][offsets[1:] > offsets[:-1]] - 1] = False
    return np.flatnonzero(is_segment).astype(np.int32)


class LostPoints(ArithmeticError):
    """Points, (n,) int64, are not finite, or farther away than a light-hour."""

    def __init__(self, points: np.ndarray) -> None:
        super().__init__(f"{len(points)} points of the hair are not finite, the first is number {points[0]}")
        self.points = points


def refuse_lost(points: np.ndarray) -> None:
    """Raise LostPoints where positions [m], (P, 3), are."""
    lost = np.empty(len(points), np.bool_)
    _find_lost(points, lost)
    if lost.any():
        raise LostPoints(np.flatnonzero(lost))


@njit(cache=True, parallel=True)
def _find_lost(points, lost):
    for k in prange(len(points)):
        x, y, z = row(points, k)
        # max may drop a NaN, depending on the order of its arguments: each is tested for itself, too.
        lost[k] = not max(abs(x), max(abs(y), abs(z))) <= FARTHEST or x != x or y != y or z != z
