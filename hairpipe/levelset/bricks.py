"""The bricks of a narrow band: which there are, and what their samples hold.

Velocities are those of the corners of the surface's triangles [m/s], (m, 3, 3) float64. Marks are those of the samples
of a lattice, from `marked_samples`, (x, y, z) uint8.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.triangle_tree import Tree, closest
from hairpipe.levelset.grid_layout import BRICK, Lattice, refuse_if_huge
from hairpipe.levelset.outer_shell import OUTSIDE
from hairpipe.values import LevelSet

SIDE = BRICK + 1
# A stored sample takes 16 bytes: 1.6 GB.
MOST_STORED = 100_000_000


class Bricks(NamedTuple):
    """The bricks of a band, as in LevelSet."""

    places: np.ndarray  # index of the brick of every block, FAR_OUTSIDE or FAR_INSIDE, (na, nb, nc) int32
    distance: np.ndarray  # [m], (B, 9, 9, 9) float32
    velocity: np.ndarray  # [m/s], (B, 9, 9, 9, 3) float32


class Band(NamedTuple):
    """Lattice of the samples, and width of the band."""

    first: np.ndarray  # index of the lattice's first sample, (3,) int64
    voxel: float  # spacing of the samples [m]
    width: float  # of the band [m]


def filled_bricks(tree: Tree, velocities: np.ndarray, lattice: Lattice, marks: np.ndarray, width: float) -> Bricks:
    """Return the bricks that a band of a width [m] around the surface touches; BadInput if they exceed the memory."""
    places = near_bricks(tree, lattice, width)
    refuse_if_huge(len(places) * SIDE**3, lattice.size, lattice.voxel, MOST_STORED)
    distance = np.empty((len(places), SIDE, SIDE, SIDE), np.float32)
    velocity = np.empty((*distance.shape, 3), np.float32)
    fill_bricks(tree, velocities, places, Band(lattice.first, lattice.voxel, width), marks, distance, velocity)
    index = np.pad(brick_index(places, marks), (0, 1), constant_values=LevelSet.FAR_OUTSIDE)
    share_samples(index, places, width, distance, velocity)
    kept = (np.abs(distance) < np.float32(width)).any(axis=(1, 2, 3))
    return Bricks(brick_index(places[kept], marks), distance[kept], velocity[kept])


def brick_index(places: np.ndarray, marks: np.ndarray) -> np.ndarray:
    """Return the index of the brick of every block, FAR_OUTSIDE or FAR_INSIDE, (na, nb, nc) int32."""
    corner = marks[:-1:BRICK, :-1:BRICK, :-1:BRICK] & OUTSIDE
    index = np.where(corner, LevelSet.FAR_OUTSIDE, LevelSet.FAR_INSIDE).astype(np.int32)
    index[tuple(places.T)] = np.arange(len(places), dtype=np.int32)
    return index


def near_bricks(tree: Tree, lattice: Lattice, width: float) -> np.ndarray:
    """Return the bricks that the band of a width [m] may touch, (n, 3) int64, in memory order; pure."""
    distances = np.empty(lattice.bricks)
    reach = width + np.sqrt(3) * BRICK / 2 * lattice.voxel  # No sample is farther from the middle of its brick.
    measure_middles(tree, lattice.first, lattice.voxel, reach, distances)
    return np.argwhere(distances < reach)


@njit(cache=True)
def measure_middles(tree: Tree, first: np.ndarray, voxel: float, reach: float, distances: np.ndarray) -> None:
    """Write the distance from the middle of every brick to the surface [m], exact within reach [m]."""
    na, nb, nc = distances.shape
    near = 0
    for a in range(na):
        for b in range(nb):
            for c in range(nc):
                x = (first[0] + BRICK * a + BRICK / 2) * voxel
                y = (first[1] + BRICK * b + BRICK / 2) * voxel
                z = (first[2] + BRICK * c + BRICK / 2) * voxel
                squared, near, _ = closest(tree, (x, y, z), reach * reach, near)  # The nearest so far is a good guess.
                distances[a, b, c] = np.sqrt(squared)


@njit(cache=True, parallel=True)
def fill_bricks(
    tree: Tree,
    velocities: np.ndarray,
    places: np.ndarray,
    band: Band,
    marks: np.ndarray,
    distance: np.ndarray,
    velocity: np.ndarray,
) -> None:
    """Fill, in place, the first 8 x 8 x 8 samples of bricks: clamped distance, and velocity of the closest point."""
    first, voxel, width = band.first, band.voxel, band.width
    for n in prange(len(places)):
        near = 0  # Of equally near triangles the guess may decide: it must not depend on what a thread did before.
        for i in range(BRICK):
            for j in range(BRICK):
                for k in range(BRICK):
                    a, b, c = BRICK * places[n, 0] + i, BRICK * places[n, 1] + j, BRICK * places[n, 2] + k
                    x, y, z = (first[0] + a) * voxel, (first[1] + b) * voxel, (first[2] + c) * voxel
                    squared, near, w = closest(tree, (x, y, z), np.inf, near)
                    t = tree.triangles[near]
                    far = np.sqrt(squared)
                    # Outside the band's border is the largest distance; inside it goes on, as hair may be deep.
                    distance[n, i, j, k] = min(far, width) if marks[a, b, c] & OUTSIDE else -far
                    for axis in range(3):
                        v0, v1, v2 = velocities[t, 0, axis], velocities[t, 1, axis], velocities[t, 2, axis]
                        velocity[n, i, j, k, axis] = w[0] * v0 + w[1] * v1 + w[2] * v2


@njit(cache=True)
def share_samples(
    index: np.ndarray, places: np.ndarray, width: float, distance: np.ndarray, velocity: np.ndarray
) -> None:
    """Fill, in place, the last samples of every brick along each axis: they are the first of the brick beyond.

    If that brick is missing, the sample is beyond the band: it takes sign and velocity of the previous sample, in a
    brick that is the same for all bricks with this sample. Inside, the distance is extrapolated.
    """
    last = BRICK - 1
    for n in range(len(places)):
        a, b, c = places[n]
        for i in range(SIDE):
            for j in range(SIDE):
                for k in range(SIDE):
                    if max(i, j, k) == BRICK:  # Copied, so that two bricks agree to the bit on their common face.
                        m, u, v, w = holder(index, BRICK * a + i, BRICK * b + j, BRICK * c + k)
                        near = distance[m, min(u, last), min(v, last), min(w, last)]
                        if max(u, v, w) < BRICK:
                            distance[n, i, j, k] = near
                        elif near > 0.0:
                            distance[n, i, j, k] = width
                        else:
                            nearer = distance[m, min(u, 2 * last - u), min(v, 2 * last - v), min(w, 2 * last - w)]
                            distance[n, i, j, k] = 2.0 * near - nearer
                        for axis in range(3):
                            velocity[n, i, j, k, axis] = velocity[m, min(u, last), min(v, last), min(w, last), axis]


@njit(cache=True)
def holder(index: np.ndarray, i: int, j: int, k: int) -> tuple[int, int, int, int]:
    """Return the first brick that contains a sample, preferably as its first sample, and the index in it."""
    for a in (i // BRICK, (i - 1) // BRICK):  # In a fixed order: all bricks that share a sample find the same holder.
        for b in (j // BRICK, (j - 1) // BRICK):
            for c in (k // BRICK, (k - 1) // BRICK):
                if index[a, b, c] >= 0:
                    return index[a, b, c], i - BRICK * a, j - BRICK * b, k - BRICK * c
    return -1, 0, 0, 0
