"""Trilinear splat and sample on a dense grid of nodes, for kernels.

A point at fractions (f, g, h) of a voxel gives to its eight nodes, or reads them with, the weights

    (1 - f or f) (1 - g or g) (1 - h or h)

so that splat is the transpose of sample: sum_n splat(amount)_n grid_n = amount sample(grid). Level sets have a reader
of their own (`levelset/sample.py`): bricks have no neighbour by index, and distance and gradient share differences of
nodes in single precision.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.kernels.compile import inlined


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
