"""Trilinear interpolation on a dense grid of nodes, and its transpose.

A point at fractions (f, g, h) of a voxel gives to its eight nodes, or reads them with, the weights

    (1 - f or f) (1 - g or g) (1 - h or h)

so that splat is the transpose of sample: sum_n splat(amount)_n grid_n = amount sample(grid). Level sets have a reader
of their own (`levelset/sample.py`): bricks have no neighbour by index, and distance and gradient share differences of
nodes in single precision.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.geometry.compile import inlined


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
                grid[at.i + a, at.j + b, at.k + c] += weight_of(at, a, b, c) * amount


@inlined
def sample(grid: np.ndarray, at: Voxel) -> float:
    """Return the value of a grid at a point of a voxel."""
    value = 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                value += weight_of(at, a, b, c) * grid[at.i + a, at.j + b, at.k + c]
    return value


@inlined
def weight_of(at: Voxel, a: int, b: int, c: int) -> float:
    """Return the weight of node (a, b, c), each 0 or 1, of a voxel."""
    return (at.f if a else 1.0 - at.f) * (at.g if b else 1.0 - at.g) * (at.h if c else 1.0 - at.h)
