"""Strands as a file has them, before they are bound to a body."""

import numpy as np

from hairpipe.data.value import value


@value
class Curves:
    """Strands of a file, root first.

    points   points of all strands, in order [m], (p, 3) float64
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,) int32
    ids      ids in the file, otherwise indices of the curves; unique, (S,) int32
    held     whether the tip is held like the root, (S,) bool
    spare    number of control points at either end of a strand beyond the ends of the curve, (S,) int64
    rest     points of the rest shape, if the file has one [m], (p, 3) float64
    widths   of the strands at all points [m], (p,) float64
    time     time code at which an animated file was read
    """

    points: np.ndarray
    offsets: np.ndarray
    ids: np.ndarray
    held: np.ndarray
    spare: np.ndarray
    rest: np.ndarray | None = None
    widths: np.ndarray | None = None
    time: float | None = None
