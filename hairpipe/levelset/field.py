"""A level set as kernels see it."""

from typing import NamedTuple

import numpy as np

from hairpipe.data import LevelSet


class Field(NamedTuple):
    """The arrays and numbers of a level set, in a form that compiled functions take.

    bricks      index of the brick at every block of space, or LevelSet.FAR_OUTSIDE, FAR_INSIDE, (na, nb, nc) int32
    distance    signed distance [m], (B, 9, 9, 9) float32
    velocity    of the nearest point of the surface [m/s], (B, 9, 9, 9, 3) float32
    inner       distance and velocity at the corners of blocks far inside, (na + 1, nb + 1, nc + 1, 4) float32
    x, y, z     position of the first sample [m]
    per_metre   samples in a metre [1/m]
    background  distance beyond the band, outside [m]
    """

    bricks: np.ndarray
    distance: np.ndarray
    velocity: np.ndarray
    inner: np.ndarray
    x: float
    y: float
    z: float
    per_metre: float
    background: float


def field_of(surface: LevelSet) -> Field:
    """Return the level set for use in kernels; its arrays are shared, not copied."""
    x, y, z = (float(value) for value in surface.origin)
    # Rounded as the samples are, so that the distance does not jump where the bricks end.
    background = float(np.float32(surface.voxel * surface.half_width))
    arrays = (surface.bricks, surface.distance, surface.velocity, surface.inner)
    return Field(*arrays, x, y, z, 1 / surface.voxel, background)
