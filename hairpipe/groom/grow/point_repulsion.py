"""Repulsion of points on a surface within their reach.

Source: G. Turk, Re-tiling polygonal surfaces, SIGGRAPH 1992; reach by density, r ~ density^(-1/2).
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.kernels.vec3 import Vector, dot, flattened, length, minus, plus, row, scaled


class Cells(NamedTuple):
    """Points sorted into cubic cells; the keys of neighbours along the last axis are consecutive.

    size    size of a cell [m]
    counts  number of cells per axis, (3,) int64
    places  cell of every point, (k, 3) int64
    order   points sorted by key, (k,) int64
    keys    keys of the cells of the sorted points, (k,) int64
    """

    size: float
    counts: np.ndarray
    places: np.ndarray
    order: np.ndarray
    keys: np.ndarray


def sort_into_cells(points: np.ndarray, size: float, furthest: float) -> Cells:
    """Sort points [m], (k, 3), into cells of a given size [m], with room around for searches up to furthest [m]."""
    margin = int(np.ceil(furthest / size))
    places = np.floor((points - points.min(axis=0)) / size).astype(np.int64) + margin
    counts = places.max(axis=0) + margin + 1
    keys = (places[:, 0] * counts[1] + places[:, 1]) * counts[2] + places[:, 2]
    order = np.argsort(keys, kind="stable")
    return Cells(size, counts, places, order, keys[order])


@njit(cache=True)
def push(i: int, j: int, points: np.ndarray, normals: np.ndarray, reach: np.ndarray) -> Vector:
    """Return the push of j on i [m]: r - d away from it, if both normals point the same way.

    It acts only within the smaller reach r of the two: otherwise a dense region would repel neighbouring sparse hair.
    """
    away = minus(row(points, i), row(points, j))
    d = length(away)
    r = min(reach[i], reach[j])
    if 0.0 < d < r and dot(row(normals, i), row(normals, j)) > 0.0:
        return scaled((r - d) / d, away)
    return 0.0, 0.0, 0.0


@njit(cache=True)
def total_push(i: int, points: np.ndarray, normals: np.ndarray, reach: np.ndarray, cells: Cells) -> Vector:
    """Return the push of all points on i [m], summed in the order of the cells."""
    span = int(np.ceil(reach[i] / cells.size))
    a, b, c = cells.places[i]
    total = (0.0, 0.0, 0.0)
    for x in range(a - span, a + span + 1):
        for y in range(b - span, b + span + 1):
            key = (x * cells.counts[1] + y) * cells.counts[2] + c
            first = np.searchsorted(cells.keys, key - span)  # Keys along the last axis are consecutive: one range.
            last = np.searchsorted(cells.keys, key + span, side="right")
            for at in range(first, last):
                total = plus(total, push(i, cells.order[at], points, normals, reach))
    return total


@njit(cache=True, parallel=True)
def repulsion(points: np.ndarray, normals: np.ndarray, reach: np.ndarray, cells: Cells) -> np.ndarray:
    """Return the push on every point in its tangent plane [m], (k, 3), for any number of threads.

    points (k, 3) and reach (k,) in m, unit normals (k, 3).
    """
    forces = np.empty_like(points)
    for i in prange(len(points)):  # Each point sums up for itself, and every pair is found twice: threads write apart.
        force = flattened(total_push(i, points, normals, reach, cells), row(normals, i))
        forces[i, 0], forces[i, 1], forces[i, 2] = force
    return forces
