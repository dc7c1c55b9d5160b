"""Mass and momentum of strands on a grid, and back: P2G and its transpose, G2P.

With the weights w_gs of sample s at node g and a_si of point i in it, whose mass is spread evenly over its samples,

    B_gi = m_i sum_s w_gs a_si / A_i
    M_g = sum_i B_gi,   V_g = sum_i B_gi v_i / M_g,   V(i) = sum_g B_gi V_g / m_i

Momentum on the grid equals momentum on the strands: sum_i m_i V(i) = sum_g M_g V_g, exactly.

Trilinear splat and sample on a dense grid of nodes, for kernels.

A point at fractions (f, g, h) of a voxel gives to its eight nodes, or reads them with, the weights

    (1 - f or f) (1 - g or g) (1 - h or h)

so that splat is the transpose of sample: sum_n splat(amount)_n grid_n = amount sample(grid). Level sets have a reader
of their own (`levelset/sample.py`): bricks have no neighbour by index, and distance and gradient share differences of
nodes in single precision.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.volume.strand_samples import StrandSamples, coordinate, share_of


class Voxel(NamedTuple):
    """The voxel that holds a point.

    i, j, k  index of its first node
    f, g, h  where the point is in it, 0 to 1
    """

    i: int
    j: int
    k: int
    f: float
    g: float
    h: float


@inlined
def voxel_at(grid: np.ndarray, u: float, v: float, w: float) -> Voxel:
    """Return the voxel of a grid (nx, ny, nz), two nodes or more along each axis, that holds a point.

    u, v, w  of the point, in voxels from the first node; a point beyond the grid is moved to its border
    """
    i, f = _clamped(u, grid.shape[0])
    j, g = _clamped(v, grid.shape[1])
    k, h = _clamped(w, grid.shape[2])
    return Voxel(i, j, k, f, g, h)


@inlined
def _clamped(u: float, count: int) -> tuple[int, float]:
    u = min(u, count - 1.0) if u > 0.0 else 0.0  # NaN becomes 0, too: no index is beyond the grid
    i = min(int(u), count - 2)
    return i, u - i


@inlined
def splat(grid: np.ndarray, at: Voxel, amount: float) -> None:
    """Add an amount to the nodes of a voxel, each its share, in place."""
    for a in range(2):
        for b in range(2):
            for c in range(2):
                grid[at.i + a, at.j + b, at.k + c] += _weight(at, a, b, c) * amount


@inlined
def sample(grid: np.ndarray, at: Voxel) -> float:
    """Return the value of a grid at a point of a voxel."""
    value = 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                value += _weight(at, a, b, c) * grid[at.i + a, at.j + b, at.k + c]
    return value


@inlined
def _weight(at: Voxel, a: int, b: int, c: int) -> float:
    return (at.f if a else 1.0 - at.f) * (at.g if b else 1.0 - at.g) * (at.h if c else 1.0 - at.h)


@inlined
def splat_row(grid: np.ndarray, at: Voxel, row: tuple[float, float, float, float]) -> None:
    """Add four amounts to the nodes of a voxel of a grid (nx, ny, nz, 4), each its share, in place."""
    for a in range(2):
        for b in range(2):
            for c in range(2):
                i = at.i + a
                j = at.j + b
                k = at.k + c
                weight = _weight(at, a, b, c)
                grid[i, j, k, 0] += weight * row[0]
                grid[i, j, k, 1] += weight * row[1]
                grid[i, j, k, 2] += weight * row[2]
                grid[i, j, k, 3] += weight * row[3]


@inlined
def sample_vector(grid: np.ndarray, at: Voxel) -> tuple[float, float, float]:
    """Return the vector of a grid (nx, ny, nz, 3) at a point of a voxel."""
    x, y, z = 0.0, 0.0, 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                i = at.i + a
                j = at.j + b
                k = at.k + c
                weight = _weight(at, a, b, c)
                x += weight * grid[i, j, k, 0]
                y += weight * grid[i, j, k, 1]
                z += weight * grid[i, j, k, 2]
    return x, y, z


_CHUNK = 128  # strands that are collected together


def deposit(samples: StrandSamples, masses: np.ndarray, velocities: np.ndarray) -> np.ndarray:
    """Return mass [kg] and momentum [kg m/s] of strands at the nodes, (nx, ny, nz, 4).

    masses  of points, finite [kg], (P,); velocities  [m/s], (P, 3)
    """
    own = np.divide(masses, samples.sums, out=np.zeros(len(masses)), where=samples.sums > 0.0)
    grid = np.zeros((*samples.counts, 4))
    for parity in range(2):
        _deposit(samples, own, velocities, parity, grid)
    return grid


@njit(cache=True, parallel=True, error_model="numpy")
def _deposit(samples, own, velocities, parity, grid):
    """Splat the samples of every second slab, own mass per piece, (P,), to the nodes, in place."""
    points, pieces, slabs = samples.points, samples.pieces, samples.slabs
    low = samples.low
    inverse = 1.0 / samples.cell
    # Slabs of one parity share no node; in each, samples come in the order of strands: sums have one order.
    for n in prange((len(slabs) - parity) // 2):
        slab = 2 * n + parity
        for at in range(slabs[slab], slabs[slab + 1]):
            k = samples.segments[at]
            t = share_of(samples.places[at], pieces[k])
            u = coordinate(points, k, t, 0, low[0], inverse)
            v = coordinate(points, k, t, 1, low[1], inverse)
            w = coordinate(points, k, t, 2, low[2], inverse)
            row = (
                own[k] + t * (own[k + 1] - own[k]),
                _momentum(own, velocities, k, t, 0),
                _momentum(own, velocities, k, t, 1),
                _momentum(own, velocities, k, t, 2),
            )
            splat_row(grid, voxel_at(grid, u, v, w), row)


@inlined
def _momentum(own, velocities, k, t, c):
    """Momentum of a sample along an axis."""
    before = own[k] * velocities[k, c]
    after = own[k + 1] * velocities[k + 1, c]
    return before + t * (after - before)


def collect(samples: StrandSamples, field: np.ndarray) -> np.ndarray:
    """Return the vectors of a field of nodes, (nx, ny, nz, 3), at points of strands, (P, 3); 0 of those left out."""
    found = np.empty((len(samples.points), 3))
    _collect(samples, field, found)
    return found


@njit(cache=True, parallel=True, error_model="numpy")
def _collect(samples, field, found):
    """Write the mean of the field over the samples of points, each by its share, in place."""
    points, offsets, pieces = samples.points, samples.offsets, samples.pieces
    low = samples.low
    inverse = 1.0 / samples.cell
    strands = len(offsets) - 1
    for chunk in prange((strands + _CHUNK - 1) // _CHUNK):
        begin = offsets[chunk * _CHUNK]  # Whole strands, so that no point is written by two threads.
        end = offsets[min((chunk + 1) * _CHUNK, strands)]
        found[begin:end] = 0.0
        for k in range(begin, end):
            for place in range(pieces[k]):
                t = share_of(place, pieces[k])
                u = coordinate(points, k, t, 0, low[0], inverse)
                v = coordinate(points, k, t, 1, low[1], inverse)
                w = coordinate(points, k, t, 2, low[2], inverse)
                x, y, z = sample_vector(field, voxel_at(field, u, v, w))
                found[k, 0] += (1.0 - t) * x
                found[k, 1] += (1.0 - t) * y
                found[k, 2] += (1.0 - t) * z
                found[k + 1, 0] += t * x
                found[k + 1, 1] += t * y
                found[k + 1, 2] += t * z
        for k in range(begin, end):
            if samples.sums[k] > 0.0:
                for c in range(3):
                    found[k, c] /= samples.sums[k]


@njit(cache=True, parallel=True, error_model="numpy")
def departures(samples: StrandSamples, velocities: np.ndarray, means: np.ndarray) -> None:
    """Replace means, (P, 3) [m/s], by the differences of velocities to them, in place; 0 for omitted strands."""
    for k in prange(len(means)):
        for c in range(3):
            means[k, c] = velocities[k, c] - means[k, c] if samples.sums[k] > 0.0 else 0.0


@njit(cache=True, parallel=True, error_model="numpy")
def mean_velocities(grid: np.ndarray, out: np.ndarray) -> None:
    """Write momentum over mass of nodes, (nx, ny, nz, 4), to out, (nx, ny, nz, 3) [m/s], in place; 0 without mass."""
    for i in prange(grid.shape[0]):
        for j in range(grid.shape[1]):
            for k in range(grid.shape[2]):
                mass = grid[i, j, k, 0]
                for c in range(3):
                    out[i, j, k, c] = grid[i, j, k, c + 1] / mass if mass > 0.0 else 0.0
