"""The signed distance of a body and its velocity, in a narrow band around the surface."""

import numpy as np

from hairpipe.data.value import value


@value
class LevelSet:
    """Cubic bricks of 8 voxels a side that cover the narrow band; everything else is far inside or far outside.

    A brick stores the 9 x 9 x 9 samples at the corners of its 8 x 8 x 8 voxels, so a point in it is interpolated
    without its neighbours. Sample (i, j, k) of brick (a, b, c) lies at origin + voxel * (8a+i, 8b+j, 8c+k).
    Blocks far inside have samples at their corners.

    bricks      index of the brick that covers a block of space, FAR_OUTSIDE or FAR_INSIDE, (na, nb, nc) int32
    distance    signed distance, negative inside, outside at most voxel*half_width [m], (B, 9, 9, 9) float32
    velocity    of the nearest point of the surface; beyond the band, of one nearby [m/s], (B, 9, 9, 9, 3) float32
    inner       the same at the corners of the blocks that are far inside: distance [m], then velocity [m/s]; elsewhere
                0, (na + 1, nb + 1, nc + 1, 4) float32
    origin      position of the first sample, a multiple of 8 voxels from the world's origin [m], (3,) float64
    voxel       spacing of the samples [m]
    half_width  of the band, in voxels
    """

    FAR_OUTSIDE = -1
    FAR_INSIDE = -2

    bricks: np.ndarray
    distance: np.ndarray
    velocity: np.ndarray
    inner: np.ndarray
    origin: np.ndarray
    voxel: float
    half_width: float
