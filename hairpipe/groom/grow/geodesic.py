"""Walking on a triangle mesh: straight on within a triangle, folded over its edges, sliding along a border."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.data import Mesh
from hairpipe.kernels.vec3 import Vector, dot, flattened, plus, row, scaled, unit
from hairpipe.spatial.triangles import area_vectors, twin_corners

MOST_CROSSINGS = 256  # a walk that circles a vertex for ever ends where it is
STANDSTILL = 1e-12  # barycentric move that is rounding error, not motion


class Terrain(NamedTuple):
    """Mesh data for a geodesic walk.

    twins      corner across the edge opposite to each corner, -1 at a border, (m, 3) int32
    gradients  gradients of the three barycentric coordinates over the triangle [1/m], (m, 3, 3) float64
    """

    twins: np.ndarray
    gradients: np.ndarray


def survey(mesh: Mesh, passable: np.ndarray) -> Terrain:
    """Return the terrain of the triangles marked passable, (m,) bool; walks never enter the others."""
    twins = twin_corners(mesh.triangles)
    twins = np.where((twins >= 0) & passable[twins // 3], twins, -1).astype(np.int32)
    corners = mesh.points[mesh.triangles]
    opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    doubled = 2.0 * area_vectors(mesh)[:, None, :]
    squared = np.sum(doubled**2, axis=-1, keepdims=True)
    gradients = np.cross(doubled, opposite)
    return Terrain(twins, np.divide(gradients, squared, out=np.zeros_like(gradients), where=squared > 0))


@njit(cache=True)
def exit_corner(b: np.ndarray, db: Vector) -> tuple[float, int]:
    """Return the fraction of the move db at which it leaves the triangle, and the corner opposite the edge left by."""
    corner, fraction = -1, 1.0
    for k in range(3):
        if db[k] < -STANDSTILL and b[k] < -fraction * db[k]:  # Compared by products, without a division.
            fraction = b[k] / -db[k]
            corner = k
    return fraction, corner


@njit(cache=True)
def walk(twins: np.ndarray, gradients: np.ndarray, t: int, b: np.ndarray, v: Vector) -> int:
    """Move the point with barycentrics b in triangle t, in place, by the tangent vector v [m]; return its triangle."""
    for _ in range(MOST_CROSSINGS):
        slopes = gradients[t]
        db = dot(row(slopes, 0), v), dot(row(slopes, 1), v), dot(row(slopes, 2), v)
        fraction, k = exit_corner(b, db)
        for j in range(3):
            b[j] = max(b[j] + fraction * db[j], 0.0)
        if k < 0:
            break
        b[k] = 0.0  # Exactly on the edge, whatever rounding left: else the walk could leave by it again.
        inward = unit(row(slopes, k), v)
        out = scaled(1.0 - fraction, v)
        v = flattened(out, inward)
        twin = twins[t, k]
        if twin >= 0:  # fold what leads out over the edge into the triangle beyond; at a border it is lost: slide on
            t = twin // 3
            j = twin % 3
            b[(j + 1) % 3], b[(j + 2) % 3], b[j] = b[(k + 2) % 3], b[(k + 1) % 3], 0.0
            v = plus(v, scaled(-dot(out, inward), unit(row(gradients[t], j), v)))
    total = b[0] + b[1] + b[2]  # Clamping above may have changed the sum.
    for j in range(3):
        b[j] /= total
    return t


@njit(cache=True, parallel=True)
def walk_all(
    twins: np.ndarray, gradients: np.ndarray, triangles: np.ndarray, barycentrics: np.ndarray, moves: np.ndarray
) -> None:
    """Move every point by its tangent vector, in place: triangles (k,), barycentrics (k, 3), moves (k, 3) [m]."""
    for i in prange(len(triangles)):
        triangles[i] = walk(twins, gradients, triangles[i], barycentrics[i], row(moves, i))
