"""Prescribed ends of strands, and pinned points, at one frame."""

import numpy as np

from hairpipe.data.value import value


@value
class Ends:
    """Both ends of every strand at one frame, as rigid motions from the groom: x -> R x + t.

    Columns are those of R, then t [m], in the coordinates of the groom. A free tip is NaN; a tip that is held at a
    frame and free at the next is released at the first of the two.

    roots       (S, 3, 4) float64
    roots_rate  derivative of roots by time [1/s, m/s], same shape
    tips        motion of the last segment and its end, same shape
    tips_rate   derivative of tips by time [1/s, m/s], same shape
    """

    roots: np.ndarray
    roots_rate: np.ndarray
    tips: np.ndarray
    tips_rate: np.ndarray


@value
class Pins:
    """Places of pinned points of a groom at one frame, and the strength of their pins.

    points      index of every pinned point in the groom, ascending, (k,) int32
    positions   place to which the point is pulled [m], (k, 3) float64
    velocities  velocity of that place [m/s], (k, 3) float64
    frequency   natural frequency of a point about its place [Hz]
    damping     ratio of damping to critical damping
    among       number of points of the groom
    """

    points: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray
    frequency: float
    damping: float
    among: int
