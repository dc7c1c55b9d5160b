"""Samples that are connected to the outside without crossing the surface."""

import numpy as np
from numba import njit

from hairpipe.levelset.grid_layout import Lattice

# Bits of a sample: the step to the next sample along x, y, z meets the surface; the sample is outside.
BLOCKED = (1, 2, 4)
OUTSIDE = 8
# A crossing this close to a sample [voxels] blocks the steps on both sides of it, so that rounding opens no leak.
TOUCH = 1e-9


def marked_samples(corners: np.ndarray, lattice: Lattice) -> np.ndarray:
    """Return the bits BLOCKED and OUTSIDE of every sample, (x, y, z) uint8; pure.

    corners  of a closed surface's triangles [m], (m, 3, 3)

    A sample is outside if a path along the lattice joins it to the border and crosses no triangle. Orientation,
    overlapping parts, and closed parts within others have no effect: all unreached samples are inside.
    """
    marks = np.zeros(lattice.samples, np.uint8)
    places = corners / lattice.voxel - lattice.first
    for axis in range(3):
        block_steps(places, axis, marks)
    marks[0] |= OUTSIDE
    while flood_forward(marks) + flood_backward(marks):
        pass
    return marks


@njit(cache=True)
def side(pu: float, pv: float, qu: float, qv: float, u: float, v: float) -> float:
    """Return twice the signed area of p, q and (u, v); exactly opposite when p and q are exchanged.

    So two triangles agree on the side of their common edge on which a line passes, and no line passes between them.
    """
    if pu < qu or (pu == qu and pv < qv):
        return (qu - pu) * (v - pv) - (qv - pv) * (u - pu)
    return (qu - pu) * (v - qv) - (qv - pv) * (u - qu)


@njit(cache=True)
def block_steps(places: np.ndarray, axis: int, marks: np.ndarray) -> None:
    """Mark, in place, the steps along one axis that meet a triangle.

    places  positions of the triangles' corners, in samples from the first, (m, 3, 3) float64
    """
    second, third = (axis + 1) % 3, (axis + 2) % 3
    step = np.zeros(3, np.int64)
    for t in range(len(places)):
        p, q, r = places[t, 0], places[t, 1], places[t, 2]
        pu, pv, qu, qv, ru, rv = p[second], p[third], q[second], q[third], r[second], r[third]
        for u in range(int(np.ceil(min(pu, qu, ru))), int(np.floor(max(pu, qu, ru))) + 1):
            for v in range(int(np.ceil(min(pv, qv, rv))), int(np.floor(max(pv, qv, rv))) + 1):
                a = side(qu, qv, ru, rv, u, v)
                b = side(ru, rv, pu, pv, u, v)
                c = side(pu, pv, qu, qv, u, v)
                within = (a >= 0 and b >= 0 and c >= 0) or (a <= 0 and b <= 0 and c <= 0)
                if not within or a + b + c == 0.0:  # Edge-on along this axis: the triangle is met along another.
                    continue
                depth = (a * p[axis] + b * q[axis] + c * r[axis]) / (a + b + c)
                step[second], step[third] = u, v
                for near in (depth - TOUCH, depth + TOUCH):
                    step[axis] = int(np.floor(near))
                    marks[step[0], step[1], step[2]] |= BLOCKED[axis]


@njit(cache=True)
def flood_forward(marks: np.ndarray) -> int:
    """Mark, in place, the samples that a step towards +x, +y or +z joins to the outside; return how many."""
    nx, ny, nz = marks.shape
    found = 0
    for i in range(nx):  # In the order of memory, neighbours before: what is found is passed on in the same pass.
        for j in range(ny):
            for k in range(nz):
                if marks[i, j, k] & OUTSIDE:
                    continue
                x = i > 0 and marks[i - 1, j, k] & (OUTSIDE | 1) == OUTSIDE
                y = j > 0 and marks[i, j - 1, k] & (OUTSIDE | 2) == OUTSIDE
                z = k > 0 and marks[i, j, k - 1] & (OUTSIDE | 4) == OUTSIDE
                if x or y or z:
                    marks[i, j, k] |= OUTSIDE
                    found += 1
    return found


@njit(cache=True)
def flood_backward(marks: np.ndarray) -> int:
    """Mark, in place, the samples that a step towards -x, -y or -z joins to the outside; return how many."""
    nx, ny, nz = marks.shape
    found = 0
    for i in range(nx - 1, -1, -1):  # The other way round: passes both ways reach all, without a queue.
        for j in range(ny - 1, -1, -1):
            for k in range(nz - 1, -1, -1):
                here = marks[i, j, k]
                if here & OUTSIDE:
                    continue
                x = i < nx - 1 and not here & 1 and marks[i + 1, j, k] & OUTSIDE
                y = j < ny - 1 and not here & 2 and marks[i, j + 1, k] & OUTSIDE
                z = k < nz - 1 and not here & 4 and marks[i, j, k + 1] & OUTSIDE
                if x or y or z:
                    marks[i, j, k] |= OUTSIDE
                    found += 1
    return found
