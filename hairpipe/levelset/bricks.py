"""The bricks of a narrow band: which there are, and what their samples hold."""

import numpy as np
from numba import njit, prange

from hairpipe.data import LevelSet
from hairpipe.levelset.closest import closest
from hairpipe.levelset.lattice import BRICK, Lattice
from hairpipe.levelset.outside import OUTSIDE
from hairpipe.levelset.tree import Tree

SIDE = BRICK + 1
STACK = 64


def near_bricks(tree: Tree, lattice: Lattice, width: float) -> np.ndarray:
    """Return the bricks that the band may touch, (n, 3) int64, in the order they lie in memory; pure.

    width  of the band [m]

    No sample of a brick is farther from its middle than half the brick's diagonal.
    """
    distances = np.empty(lattice.bricks)
    reach = width + np.sqrt(3) * BRICK / 2 * lattice.voxel
    measure_middles(tree, lattice.first, lattice.voxel, reach, distances)
    return np.argwhere(distances < reach)


@njit(cache=True)
def measure_middles(tree: Tree, first: np.ndarray, voxel: float, reach: float, distances: np.ndarray) -> None:
    """Measure, in place, the distance from the middle of every brick to the surface [m], exact within reach [m]."""
    na, nb, nc = distances.shape
    nodes, bounds = np.empty(STACK, np.int64), np.empty(STACK)
    near = 0
    for a in range(na):
        for b in range(nb):
            for c in range(nc):
                x = (first[0] + BRICK * a + BRICK / 2) * voxel
                y = (first[1] + BRICK * b + BRICK / 2) * voxel
                z = (first[2] + BRICK * c + BRICK / 2) * voxel
                squared, near, _, _ = closest(tree, x, y, z, reach * reach, near, nodes, bounds)
                distances[a, b, c] = np.sqrt(squared)


@njit(cache=True, parallel=True)
def fill_bricks(
    tree: Tree,
    bricks: np.ndarray,
    first: np.ndarray,
    voxel: float,
    width: float,
    marks: np.ndarray,
    distance: np.ndarray,
    velocity: np.ndarray,
) -> None:
    """Fill, in place, the samples of the bricks: signed distance, clamped to the band, velocity of the closest point.

    In what lies beyond the band in a brick the velocity is that of a point nearby.

    bricks    index of each along the axes, (n, 3) int64
    first     index of the lattice's first sample, (3,) int64
    voxel     spacing of the samples [m]
    width     of the band [m]
    marks     of the lattice's samples, from outside.marked_samples, (x, y, z) uint8
    distance  [m], (n, 9, 9, 9) float32
    velocity  [m/s], (n, 9, 9, 9, 3) float32
    """
    velocities = tree.velocities
    for n in prange(len(bricks)):
        nodes, bounds = np.empty(STACK, np.int64), np.empty(STACK)
        near = 0
        for i in range(SIDE):
            for j in range(SIDE):
                for k in range(SIDE):
                    a, b, c = BRICK * bricks[n, 0] + i, BRICK * bricks[n, 1] + j, BRICK * bricks[n, 2] + k
                    x, y, z = (first[0] + a) * voxel, (first[1] + b) * voxel, (first[2] + c) * voxel
                    squared, near, s, r = closest(tree, x, y, z, width * width, near, nodes, bounds)
                    far = min(np.sqrt(squared), width)
                    distance[n, i, j, k] = far if marks[a, b, c] & OUTSIDE else -far
                    for axis in range(3):
                        v0, v1, v2 = velocities[near, 0, axis], velocities[near, 1, axis], velocities[near, 2, axis]
                        velocity[n, i, j, k, axis] = v0 + s * (v1 - v0) + r * (v2 - v0)


def brick_index(kept: np.ndarray, marks: np.ndarray, lattice: Lattice) -> np.ndarray:
    """Return the number of the brick at every place, FAR_OUTSIDE or FAR_INSIDE, (na, nb, nc) int32; pure.

    kept  places that have a brick, (n, 3) int64; all samples of any other place are on one side
    """
    corner = marks[:-1:BRICK, :-1:BRICK, :-1:BRICK] & OUTSIDE
    index = np.where(corner, LevelSet.FAR_OUTSIDE, LevelSet.FAR_INSIDE).astype(np.int32)
    index[tuple(kept.T)] = np.arange(len(kept), dtype=np.int32)
    return index
