"""Even triangles: vertices slide within the surface towards the middle of their neighbours."""

from collections.abc import Callable

import numpy as np


def relax(
    points: np.ndarray, triangles: np.ndarray, project: Callable[[np.ndarray], np.ndarray], rounds: int
) -> np.ndarray:
    """Slide the vertices of a closed surface towards the mean of their neighbours, `rounds` times. Pure.

    points     [m], (n, 3)
    triangles  (m, 3), closed: every edge is seen once in each direction
    project    puts points back on the surface
    """
    tail = triangles.ravel()
    head = triangles[:, (1, 2, 0)].ravel()
    neighbours = np.bincount(tail, minlength=len(points))[:, None]
    for _ in range(rounds):
        total = np.stack([np.bincount(tail, points[head, axis], len(points)) for axis in range(3)], axis=1)
        shift = total / neighbours - points
        normals = _normals(points, triangles)
        shift -= np.einsum("ij,ij->i", shift, normals)[:, None] * normals
        points = project(points + 0.5 * shift)
    return points


def _normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the unit normals of the vertices, their triangles weighted by area, (n, 3).

    Unlike `spatial.triangles.vertex_normals` it adds first corners, then second, then third ones: the last bits of the
    bust, and so of all hair that was grown on it, depend on the order.
    """
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    doubled_area = np.cross(b - a, c - a)
    total = np.zeros_like(points)
    for corner in range(3):
        for axis in range(3):
            total[:, axis] += np.bincount(triangles[:, corner], doubled_area[:, axis], len(points))
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300)
