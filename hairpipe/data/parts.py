"""A body as a few level sets, one for each group of bones, each in a frame that moves with its bones."""

import numpy as np

from hairpipe.data.value import value


@value
class BodyParts:
    """The parts of a body at one frame; the body is their union.

    A part k is a level set in its own frame: X = R_k^T (x - p_k), with poses[k] = [R_k | p_k] and R_k a rotation. It
    consists of bricks, like a LevelSet. The index of its (na, nb, nc) blocks is stored flat from starts[k] on.

    names       names of the parts: those of their bones
    poses       [R | p] of the parts [m], (G, 3, 4) float64
    rates       their time derivatives [1/s, m/s], (G, 3, 4) float64
    starts      start of every part in `bricks`, (G + 1,) int64
    shapes      number of blocks of a part along the axes, (G, 3) int32
    origins     position of the first sample of a part in its frame [m], (G, 3) float64
    bricks      index of the brick at every block of space, LevelSet.FAR_OUTSIDE or FAR_INSIDE, int32
    distance    signed, negative inside, outside at most voxel*half_width [m], (B, 9, 9, 9) float32
    inner       the same at the corners of blocks, see LevelSet: of all parts, (na + 1) (nb + 1) (nc + 1) of each [m],
                float32
    voxel       spacing of the samples [m]
    half_width  of the band, in voxels
    """

    names: tuple[str, ...]
    poses: np.ndarray
    rates: np.ndarray
    starts: np.ndarray
    shapes: np.ndarray
    origins: np.ndarray
    bricks: np.ndarray
    distance: np.ndarray
    inner: np.ndarray
    voxel: float
    half_width: float
