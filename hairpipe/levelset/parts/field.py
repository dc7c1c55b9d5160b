"""The parts of a body at a frame as kernels see them, each read in its own frame."""

from typing import NamedTuple

import numpy as np

from hairpipe.data import BodyParts, LevelSet
from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector

FAR_OUTSIDE = LevelSet.FAR_OUTSIDE


class PartField(NamedTuple):
    """The arrays and numbers of BodyParts, without their poses.

    starts, shapes, origins, bricks, distance, inner  as in BodyParts
    corners     start of the corners of every part in `inner`, (G,) int64
    per_metre   samples per metre [1/m]
    background  distance beyond the band, outside [m]
    """

    starts: np.ndarray
    shapes: np.ndarray
    origins: np.ndarray
    bricks: np.ndarray
    distance: np.ndarray
    inner: np.ndarray
    corners: np.ndarray
    per_metre: float
    background: float


def part_field_of(parts: BodyParts) -> PartField:
    """Return the parts for use in kernels; their arrays are shared, not copied."""
    # Rounded as the samples are, so that the distance does not jump where the bricks end.
    background = float(np.float32(parts.voxel * parts.half_width))
    counts = np.prod(parts.shapes.astype(np.int64) + 1, axis=1)
    arrays = (parts.starts, parts.shapes, parts.origins, parts.bricks, parts.distance, parts.inner)
    return PartField(*arrays, np.cumsum(counts) - counts, 1 / parts.voxel, background)


@inlined
def part_distance(field: PartField, part: int, X: Vector) -> float:
    """Return the signed distance to a part [m] at a point in its frame [m]; far outside that of the band's border."""
    na, nb, nc = field.shapes[part, 0], field.shapes[part, 1], field.shapes[part, 2]
    u = (X[0] - field.origins[part, 0]) * field.per_metre
    v = (X[1] - field.origins[part, 1]) * field.per_metre
    w = (X[2] - field.origins[part, 2]) * field.per_metre
    phi = field.background
    if 0.0 <= u < 8.0 * na and 0.0 <= v < 8.0 * nb and 0.0 <= w < 8.0 * nc:
        i, j, k = int(u), int(v), int(w)
        n = field.bricks[field.starts[part] + ((i >> 3) * nb + (j >> 3)) * nc + (k >> 3)]
        if n >= 0:
            phi = between_samples(field.distance, n, (i & 7, j & 7, k & 7), (u - i, v - j, w - k))
        elif n != FAR_OUTSIDE:
            phi = between_corners(field, part, u, v, w)
    return phi


@inlined
def between_corners(field: PartField, part: int, u: float, v: float, w: float) -> float:
    """Return the signed distance [m] far inside a part, (u, v, w) samples from its first: that of a block's corners."""
    d = field.inner
    nb = field.shapes[part, 1] + 1
    nc = field.shapes[part, 2] + 1
    a, b, c = int(u) >> 3, int(v) >> 3, int(w) >> 3
    f, g, h = 0.125 * u - a, 0.125 * v - b, 0.125 * w - c
    n = field.corners[part] + (a * nb + b) * nc + c
    m = n + nb * nc
    c00 = d[n] + f * (d[m] - d[n])
    c01 = d[n + 1] + f * (d[m + 1] - d[n + 1])
    c10 = d[n + nc] + f * (d[m + nc] - d[n + nc])
    c11 = d[n + nc + 1] + f * (d[m + nc + 1] - d[n + nc + 1])
    low, high = c00 + g * (c10 - c00), c01 + g * (c11 - c01)
    return low + h * (high - low)


@inlined
def between_samples(d: np.ndarray, n: int, voxel: tuple[int, int, int], fractions: Vector) -> float:
    """Return the samples d of brick n, blended in a voxel at fractions of its edges."""
    (i, j, k), (f, g, h) = voxel, fractions
    c00 = d[n, i, j, k] + f * (d[n, i + 1, j, k] - d[n, i, j, k])
    c01 = d[n, i, j, k + 1] + f * (d[n, i + 1, j, k + 1] - d[n, i, j, k + 1])
    c10 = d[n, i, j + 1, k] + f * (d[n, i + 1, j + 1, k] - d[n, i, j + 1, k])
    c11 = d[n, i, j + 1, k + 1] + f * (d[n, i + 1, j + 1, k + 1] - d[n, i, j + 1, k + 1])
    low, high = c00 + g * (c10 - c00), c01 + g * (c11 - c01)
    return low + h * (high - low)
