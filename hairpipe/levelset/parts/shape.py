"""The shape of a part between two frames, in its own frame: blended from that at the two."""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector
from hairpipe.levelset.grid_layout import BRICK
from hairpipe.levelset.parts.field import FAR_OUTSIDE, PartField, part_distance
from hairpipe.levelset.parts.pose_path import PartPoses


class Shape(NamedTuple):
    """Source of the distance to a part.

    before, after  the parts at the two frames
    changes        whether the shape of a part differs in the second frame, (G,) bool
    part           its index
    """

    before: PartField
    after: PartField
    changes: np.ndarray
    part: int


@inlined
def shape_distance(shape: Shape, a: float, X: Vector) -> float:
    """Return the signed distance [m] to a part, a frames after the first, at a point in its frame [m]."""
    phi = part_distance(shape.before, shape.part, X)
    if shape.changes[shape.part]:  # A shape that is the same in both frames is read once.
        phi += a * (part_distance(shape.after, shape.part, X) - phi)
    return phi


@inlined
def shape_gradient(shape: Shape, a: float, X: Vector) -> Vector:
    """Return the gradient of the distance by central differences over one voxel, as `sample.gradient` does."""
    e = 0.5 / shape.before.per_metre
    per = shape.before.per_metre
    gx = gy = gz = 0.0
    for side in (-1.0, 1.0):
        gx += side * per * shape_distance(shape, a, (X[0] + side * e, X[1], X[2]))
        gy += side * per * shape_distance(shape, a, (X[0], X[1] + side * e, X[2]))
        gz += side * per * shape_distance(shape, a, (X[0], X[1], X[2] + side * e))
    return gx, gy, gz


@inlined
def shape_change(shape: Shape, X: Vector) -> float:
    """Return by how much the distance at a point of the part's frame grows over the frame [m]."""
    change = 0.0
    if shape.changes[shape.part]:
        change = part_distance(shape.after, shape.part, X) - part_distance(shape.before, shape.part, X)
    return change


@inlined
def place_in(part_poses: PartPoses, t: int, part: int, x: Vector) -> Vector:
    """Return a point of the world [m] in the frame of a part, R^T (x - p)."""
    R, p = part_poses.turns, part_poses.places
    u, v, w = x[0] - p[t, part, 0], x[1] - p[t, part, 1], x[2] - p[t, part, 2]
    return (
        R[t, part, 0, 0] * u + R[t, part, 1, 0] * v + R[t, part, 2, 0] * w,
        R[t, part, 0, 1] * u + R[t, part, 1, 1] * v + R[t, part, 2, 1] * w,
        R[t, part, 0, 2] * u + R[t, part, 1, 2] * v + R[t, part, 2, 2] * w,
    )


@inlined
def turned_out(part_poses: PartPoses, t: int, part: int, g: Vector) -> Vector:
    """Return a vector in the frame of a part in the world, R g."""
    R = part_poses.turns
    return (
        R[t, part, 0, 0] * g[0] + R[t, part, 0, 1] * g[1] + R[t, part, 0, 2] * g[2],
        R[t, part, 1, 0] * g[0] + R[t, part, 1, 1] * g[1] + R[t, part, 1, 2] * g[2],
        R[t, part, 2, 0] * g[0] + R[t, part, 2, 1] * g[1] + R[t, part, 2, 2] * g[2],
    )


@inlined
def velocity_of(part_poses: PartPoses, t: int, part: int, x: Vector) -> Vector:
    """Return the velocity [m/s] of the part's frame at a point of the world [m], dp/dt + omega x (x - p)."""
    p, w, d = part_poses.places, part_poses.spins, part_poses.drifts
    u, v, z = x[0] - p[t, part, 0], x[1] - p[t, part, 1], x[2] - p[t, part, 2]
    return (
        d[t, part, 0] + w[t, part, 1] * z - w[t, part, 2] * v,
        d[t, part, 1] + w[t, part, 2] * u - w[t, part, 0] * z,
        d[t, part, 2] + w[t, part, 0] * v - w[t, part, 1] * u,
    )


@njit(cache=True)
def largest_changes(before: PartField, after: PartField, changes: np.ndarray) -> np.ndarray:
    """Return the largest change of the distance to every part over the frame, in its own frame [m], (G,); pure.

    Values deeper inside than the band are clamped to its border: there the closest point may jump.

    changes  whether the shape changes, (G,)
    """
    found = np.zeros(len(changes))
    for part in np.flatnonzero(changes):
        found[part] = max(largest_change(before, after, part), largest_change(after, before, part))
    return found


@njit(cache=True)
def largest_change(one: PartField, other: PartField, part: int) -> float:
    """Return the same over the bricks that a part has at one frame; those of two frames coincide."""
    largest = 0.0
    na, nb, nc = one.shapes[part]
    width = np.float32(one.background)
    # Boxes of two frames may begin at different bricks, a whole number of them apart.
    ahead = np.rint((one.origins[part] - other.origins[part]) * one.per_metre / BRICK).astype(np.int64)
    for i, j, k in np.ndindex(na, nb, nc):
        n = one.bricks[one.starts[part] + (i * nb + j) * nc + k]
        if n >= 0:
            m = brick_of(other, part, i + ahead[0], j + ahead[1], k + ahead[2])
            if m >= 0:
                change = np.abs(np.maximum(other.distance[m], -width) - np.maximum(one.distance[n], -width)).max()
            else:
                far = other.background if m == FAR_OUTSIDE else -other.background
                change = np.abs(far - np.maximum(one.distance[n], -width)).max()
            largest = max(largest, change)
    return largest


@njit(cache=True)
def brick_of(field: PartField, part: int, i: int, j: int, k: int) -> int:
    """Return the index of the brick of a part at a block of space, FAR_OUTSIDE or FAR_INSIDE where there is none."""
    na, nb, nc = field.shapes[part]
    if 0 <= i < na and 0 <= j < nb and 0 <= k < nc:
        return field.bricks[field.starts[part] + (i * nb + j) * nc + k]
    return FAR_OUTSIDE
