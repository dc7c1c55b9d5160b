"""Pairs of segments that are near each other."""

from typing import NamedTuple

import numpy as np


class Pairs(NamedTuple):
    """Pairs of segments and their closest points.

    segments   a segment joins a point to the next of its strand and has its number; first < second, rows in
               lexicographic order, (n, 2) int32
    fractions  where on the segments the closest points are, 0 at that point and 1 at the next, (n, 2)
    distances  between them [m], (n,)
    """

    segments: np.ndarray
    fractions: np.ndarray
    distances: np.ndarray
