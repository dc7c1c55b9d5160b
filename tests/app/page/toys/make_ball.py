"""The body of the shot."""

import numpy as np

from hairpipe.engine import node
from hairpipe.values import LevelSet


@node(frames="once")
def make_ball(*, radius: float = 0.1) -> LevelSet:
    """A level set of a ball around the origin, of eight bricks.

    radius  of it
    """
    along = 0.02 * np.arange(-8, 9)
    distance = (np.sqrt(sum(axis**2 for axis in np.meshgrid(along, along, along, indexing="ij"))) - radius).clip(
        -0.06, 0.06
    )
    bricks = [distance[a : a + 9, b : b + 9, c : c + 9] for a in (0, 8) for b in (0, 8) for c in (0, 8)]
    origin = np.full(3, along[0])
    still = np.zeros((8, 9, 9, 9, 3), np.float32)
    index = np.arange(8, dtype=np.int32).reshape(2, 2, 2)
    return LevelSet(index, np.array(bricks, np.float32), still, np.zeros((3, 3, 3, 4), np.float32), origin, 0.02, 3.0)
