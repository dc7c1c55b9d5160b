"""The axis of hair: of a curl the line that it winds about, of other hair the hair itself.

The tangent of a curl rotates about its axis, so the axis defines its direction. The axis at a point is the mean of the
curve over one turn about it; within half a turn of an end it is extrapolated along its tangent.
"""

import numpy as np

from hairpipe.data import Groom
from hairpipe.groom.helix import centres_of, turn_of


def axes_of(groom: Groom) -> np.ndarray:
    """Return the axes of all strands, point by point [m], (p, 3) float64; pure."""
    axes = groom.points.copy()
    for begin, end in zip(groom.offsets[:-1], groom.offsets[1:], strict=True):
        turn = turn_of(groom.points[begin:end])
        if 2.0 < turn <= end - begin - 2:
            axes[begin:end] = _axis_of(groom.points[begin:end], turn)
    return axes


def curls_of(groom: Groom) -> np.ndarray:
    """Return the strands that are curls of one turn or more, (n,) int64; pure.

    Their total turning is at least one turn, and they wind about an axis.
    """
    ways = np.diff(groom.points, axis=0)
    units = ways / np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), np.finfo(float).tiny)
    angles = np.arccos(np.clip(np.sum(units[1:] * units[:-1], axis=1), -1.0, 1.0))
    inner = np.ones(len(groom.points), bool)
    inner[groom.offsets[:-1]] = inner[groom.offsets[1:] - 1] = False
    strands = np.repeat(np.arange(len(groom.ids)), np.diff(groom.offsets))[1:-1]
    bends = np.bincount(strands, np.where(inner[1:-1], angles, 0.0), len(groom.ids))
    ends = [(k, groom.offsets[k], groom.offsets[k + 1]) for k in np.flatnonzero(bends >= 2.0 * np.pi)]
    found = [k for k, begin, end in ends if 2.0 < turn_of(groom.points[begin:end]) <= end - begin - 1]
    return np.array(found, np.int64)


def _axis_of(points: np.ndarray, turn: float) -> np.ndarray:
    """Return the axis of a curl, (n, 3), of so many segments a turn."""
    centres, middle = centres_of(points, turn)
    axis = np.empty_like(points)
    at = np.arange(len(points))
    axis[middle] = centres
    way = (centres[-1] - centres[0]) / max(len(middle) - 1, 1)
    before = at[: middle[0]]
    after = at[middle[-1] + 1 :]
    axis[before] = centres[0] - (middle[0] - before)[:, None] * way
    axis[after] = centres[-1] + (after - middle[-1])[:, None] * way
    return axis
