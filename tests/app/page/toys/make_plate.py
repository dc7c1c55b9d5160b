"""A mesh."""

import numpy as np

from hairpipe.engine import node
from hairpipe.values import Mesh


@node(frames="once")
def make_plate(*, size: float = 0.2) -> Mesh:
    """A square below the hair.

    size  of a side
    """
    points = size * np.array([[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]) / 2
    return Mesh(points, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
