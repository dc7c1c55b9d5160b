"""Blocks without bricks far inside a body: distance and velocity at their corners."""

import numpy as np
from numba import njit, prange

from hairpipe.data import LevelSet
from hairpipe.levelset.grid_layout import BRICK, Lattice
from hairpipe.spatial.closest import closest
from hairpipe.spatial.triangle_tree import Tree


def inner_corners(tree: Tree, velocities: np.ndarray, lattice: Lattice, places: np.ndarray) -> np.ndarray:
    """Return signed distance [m] and velocity [m/s] at the corners of blocks far inside, 0 at others; pure.

    tree        tree over the surface
    velocities  velocities of the corners of the surface's triangles [m/s], (m, 3, 3) float64
    places      index of the brick of every block, FAR_OUTSIDE or FAR_INSIDE, (na, nb, nc) int32
    returns     (na + 1, nb + 1, nc + 1, 4) float32

    Between them, a distance with a radius of curvature R has an error of up to (8 voxel)^2 / 4 R.
    """
    corners = np.zeros((*np.add(places.shape, 1), 4), np.float32)
    far = np.pad(places == LevelSet.FAR_INSIDE, 1)
    touched = np.zeros(corners.shape[:3], bool)
    for a, b, c in np.ndindex(2, 2, 2):
        touched |= far[a : a + touched.shape[0], b : b + touched.shape[1], c : c + touched.shape[2]]
    _fill(tree, velocities, np.ascontiguousarray(np.argwhere(touched)), lattice.first, lattice.voxel, corners)
    return corners


@njit(cache=True, parallel=True)
def _fill(
    tree: Tree, velocities: np.ndarray, which: np.ndarray, first: np.ndarray, voxel: float, corners: np.ndarray
) -> None:
    """Fill the corners which, (n, 3) int64, in place."""
    for n in prange(len(which)):
        a, b, c = which[n]
        x, y, z = (first[0] + BRICK * a) * voxel, (first[1] + BRICK * b) * voxel, (first[2] + BRICK * c) * voxel
        squared, near, w = closest(tree, (x, y, z), np.inf, 0)
        t = tree.triangles[near]
        corners[a, b, c, 0] = -np.sqrt(squared)  # Inside, so the sign is known without `marks`.
        for axis in range(3):
            v0, v1, v2 = velocities[t, 0, axis], velocities[t, 1, axis], velocities[t, 2, axis]
            corners[a, b, c, 1 + axis] = w[0] * v0 + w[1] * v1 + w[2] * v2
