"""Mass and momentum of strands on a dense grid of nodes, and back: P2G and its transpose, G2P.

With the weights w_gs of sample s at node g and a_si of point i in it, whose mass is spread evenly over its samples,

    B_gi = m_i sum_s w_gs a_si / A_i
    M_g = sum_i B_gi,   V_g = sum_i B_gi v_i / M_g,   V(i) = sum_g B_gi V_g / m_i

Momentum on the grid equals momentum on the strands: sum_i m_i V(i) = sum_g M_g V_g, exactly.

The weights are trilinear: a point at fractions (f, g, h) of a voxel gives to its eight nodes, or reads them with,

    (1 - f or f) (1 - g or g) (1 - h or h)

so that splat is the transpose of sample: sum_n splat(amount)_n grid_n = amount sample(grid). Level sets have a reader
of their own (`levelset/sample.py`): bricks have no neighbour by index, and distance and gradient share differences of
nodes in single precision.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.volume.strand_samples import StrandSamples, cells_of, share_of


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


_CHUNK = 128  # strands that are collected together


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


def deposit(samples: StrandSamples, masses: np.ndarray, velocities: np.ndarray) -> np.ndarray:
    """Return mass [kg] and momentum [kg m/s] of strands at the nodes, (nx, ny, nz, 4).

    masses  of points, finite [kg], (P,); velocities  [m/s], (P, 3)
    """
    own = np.divide(masses, samples.sums, out=np.zeros(len(masses)), where=samples.sums > 0.0)
    amounts = np.column_stack([own, own[:, None] * velocities])
    grid = np.zeros((*samples.counts, 4))
    for parity in range(2):
        _deposit(samples, amounts, parity, grid)
    return grid


@njit(cache=True, parallel=True, error_model="numpy")
def _deposit(samples, amounts, parity, grid):
    """Splat the samples of every second slab, with mass and momentum of points per piece, (P, 4), to the nodes."""
    slabs = samples.slabs
    inverse = 1.0 / samples.cell
    # Slabs of one parity share no node; in each, samples come in the order of strands: sums have one order.
    for n in prange((len(slabs) - parity) // 2):
        slab = 2 * n + parity
        for at in range(slabs[slab], slabs[slab + 1]):
            k = samples.segments[at]
            t = share_of(samples.places[at], samples.pieces[k])
            row = _mean(amounts, k, t, 0), _mean(amounts, k, t, 1), _mean(amounts, k, t, 2), _mean(amounts, k, t, 3)
            u, v, w = cells_of(samples, k, t, inverse)
            voxel = voxel_at(grid, u, v, w)
            for a in range(2):
                for b in range(2):
                    for c in range(2):
                        weight = _weight(voxel, a, b, c)
                        for d in range(4):
                            grid[voxel.i + a, voxel.j + b, voxel.k + c, d] += weight * row[d]


@inlined
def _mean(amounts, k, t, d):
    return amounts[k, d] + t * (amounts[k + 1, d] - amounts[k, d])


@njit(cache=True, parallel=True, error_model="numpy")
def collect(samples: StrandSamples, field: np.ndarray) -> np.ndarray:
    """Return the vectors of a field of nodes, (nx, ny, nz, 3), at points of strands, (P, 3); 0 of those left out."""
    found = np.empty((len(samples.points), 3))
    offsets = samples.offsets
    pieces = samples.pieces
    inverse = 1.0 / samples.cell
    strands = len(offsets) - 1
    for chunk in prange((strands + _CHUNK - 1) // _CHUNK):
        begin = offsets[chunk * _CHUNK]  # Whole strands, so that no point is written by two threads.
        end = offsets[min((chunk + 1) * _CHUNK, strands)]
        found[begin:end] = 0.0
        for k in range(begin, end):
            for place in range(pieces[k]):
                t = share_of(place, pieces[k])
                u, v, w = cells_of(samples, k, t, inverse)
                vector = _sample_vector(field, voxel_at(field, u, v, w))
                for c in range(3):
                    found[k, c] += (1.0 - t) * vector[c]
                    found[k + 1, c] += t * vector[c]
        for k in range(begin, end):
            if samples.sums[k] > 0.0:
                for c in range(3):
                    found[k, c] /= samples.sums[k]
    return found


@inlined
def _sample_vector(grid, at):
    x, y, z = 0.0, 0.0, 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                weight = _weight(at, a, b, c)
                i, j, k = at.i + a, at.j + b, at.k + c
                x += weight * grid[i, j, k, 0]
                y += weight * grid[i, j, k, 1]
                z += weight * grid[i, j, k, 2]
    return x, y, z


@njit(cache=True, parallel=True, error_model="numpy")
def mean_velocities(grid: np.ndarray, out: np.ndarray) -> None:
    """Write momentum over mass of nodes, (nx, ny, nz, 4), to out, (nx, ny, nz, 3) [m/s], in place; 0 without mass."""
    nodes = grid.reshape(-1, 4)
    vectors = out.reshape(-1, 3)
    for k in prange(len(nodes)):
        for c in range(3):
            vectors[k, c] = nodes[k, c + 1] / nodes[k, 0] if nodes[k, 0] > 0.0 else 0.0
