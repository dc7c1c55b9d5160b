"""The axis that hair runs along: of a curl the line that it turns about, of other hair the hair itself.

A direction along the hair is to say where the hair leads; that of a curl turns about its axis. The axis at a point is
the mean of the curve over one turn about it; nearer to an end than half a turn it goes straight on, as it does there.
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


def _axis_of(points: np.ndarray, turn: float) -> np.ndarray:
    """Return the axis of a curl, (n, 3), of so many segments a turn."""
    centres, middle = centres_of(points, turn)
    axis, at = np.empty_like(points), np.arange(len(points))
    axis[middle] = centres
    way = (centres[-1] - centres[0]) / max(len(middle) - 1, 1)
    before, after = at[: middle[0]], at[middle[-1] + 1 :]
    axis[before] = centres[0] - (middle[0] - before)[:, None] * way
    axis[after] = centres[-1] + (after - middle[-1])[:, None] * way
    return axis
