"""Strands as a file has them, before they are bound to a body."""

import numpy as np

from hairpipe.data.value import value


@value
class Curves:
    """Strands of a file, root first.

    points   of all strands, one after another [m], (p, 3) float64
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,) int32
    ids      that the file gives them, else their places in it; unique, (S,) int32
    held     whether the tip is held as the root is, (S,) bool
    spare    points at either end of a strand beyond where the file says that the curve ends, (S,) int64
    rest     of all points in the rest shape that the file has besides [m], (p, 3) float64
    widths   of the strands at all points [m], (p,) float64
    time     code at which a file that moves them was read
    """

    points: np.ndarray
    offsets: np.ndarray
    ids: np.ndarray
    held: np.ndarray
    spare: np.ndarray
    rest: np.ndarray | None = None
    widths: np.ndarray | None = None
    time: float | None = None
