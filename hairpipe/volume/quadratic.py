"""Quadratic B-splines on a dense grid of nodes: splatting of samples, and its gradient.

Along an axis, with d = u - i from the nearest node i, -1/2 to 1/2, the three nodes around it have

    w = (1/2 - d)^2 / 2,   3/4 - d^2,   (1/2 + d)^2 / 2
    w' = d - 1/2,          -2 d,        d + 1/2

Unlike the tents of `trilinear`, a density of these has a gradient that does not jump across faces of cells. Grids here
have a margin of a node on every side: sample (0, 0, 0) of the grid is the node before the first one around the hair.
"""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector
from hairpipe.volume.strand_samples import StrandSamples, coordinate, share_of

_CHUNK = 128  # strands that are collected together


def weigh(samples: StrandSamples, amounts: np.ndarray) -> np.ndarray:
    """Splat amounts of points, (P,), to the nodes, (nx + 2, ny + 2, nz + 2)."""
    own = np.divide(amounts, samples.sums, out=np.zeros(len(amounts)), where=samples.sums > 0.0)
    grid = np.zeros(samples.counts + 2)
    for parity in range(2):
        _weigh(samples, own, parity, grid)
    return grid


@njit(cache=True, parallel=True, error_model="numpy")
def _weigh(samples, own, parity, grid):
    """Splat the samples of every second slab to the nodes, in place: these slabs share no nodes."""
    points, pieces, slabs = samples.points, samples.pieces, samples.slabs
    low = samples.low
    inverse = 1.0 / samples.cell
    for n in prange((len(slabs) - parity) // 2):  # Three nodes reach one plane beyond a slab: every second is apart.
        slab = 2 * n + parity
        for at in range(slabs[slab], slabs[slab + 1]):
            k = samples.segments[at]
            t = share_of(samples.places[at], pieces[k])
            amount = own[k] + t * (own[k + 1] - own[k])
            i, x = _around(coordinate(points, k, t, 0, low[0], inverse))
            j, y = _around(coordinate(points, k, t, 1, low[1], inverse))
            l, z = _around(coordinate(points, k, t, 2, low[2], inverse))
            wx, wy, wz = _weights(x), _weights(y), _weights(z)
            for a in range(3):
                for b in range(3):
                    for c in range(3):
                        grid[i + a, j + b, l + c] += amount * wx[a] * wy[b] * wz[c]


@njit(cache=True, parallel=True, error_model="numpy")
def add_slopes(samples: StrandSamples, own: np.ndarray, field: np.ndarray, out: np.ndarray) -> None:
    """Add the derivative of sum_g field_g amount_g by every point to out, (P, 3), in place.

    own    amounts of points for each of their pieces, amounts / sums, (P,)
    field  at the nodes, (nx + 2, ny + 2, nz + 2)
    """
    points, offsets, pieces = samples.points, samples.offsets, samples.pieces
    low = samples.low
    inverse = 1.0 / samples.cell
    strands = len(offsets) - 1
    for chunk in prange((strands + _CHUNK - 1) // _CHUNK):
        for k in range(offsets[chunk * _CHUNK], offsets[min((chunk + 1) * _CHUNK, strands)]):
            for place in range(pieces[k]):
                t = share_of(place, pieces[k])
                u = coordinate(points, k, t, 0, low[0], inverse)
                v = coordinate(points, k, t, 1, low[1], inverse)
                w = coordinate(points, k, t, 2, low[2], inverse)
                slope = _slope(field, u, v, w)
                amount = inverse * (own[k] + t * (own[k + 1] - own[k]))
                for c in range(3):
                    out[k, c] += (1.0 - t) * amount * slope[c]
                    out[k + 1, c] += t * amount * slope[c]


@inlined
def _slope(field: np.ndarray, u: float, v: float, w: float) -> Vector:
    """Return the gradient of the spline of a field at a point, by cells."""
    i, x = _around(u)
    j, y = _around(v)
    l, z = _around(w)
    wx = _weights(x)
    wy = _weights(y)
    wz = _weights(z)
    dx = _slopes(x)
    dy = _slopes(y)
    dz = _slopes(z)
    gx, gy, gz = 0.0, 0.0, 0.0
    for a in range(3):
        for b in range(3):
            for c in range(3):
                value = field[i + a, j + b, l + c]
                gx += dx[a] * wy[b] * wz[c] * value
                gy += wx[a] * dy[b] * wz[c] * value
                gz += wx[a] * wy[b] * dz[c] * value
    return gx, gy, gz


@inlined
def _around(u: float) -> tuple[int, float]:
    """Index of the first of the three nodes around a place, with the margin, and how far from the second it is."""
    i = int(np.floor(u + 0.5))
    return i, u - i


@inlined
def _weights(d: float) -> Vector:
    return 0.5 * (0.5 - d) ** 2, 0.75 - d * d, 0.5 * (0.5 + d) ** 2


@inlined
def _slopes(d: float) -> Vector:
    return d - 0.5, -2.0 * d, d + 0.5
