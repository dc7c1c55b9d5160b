"""The shape of a part between two frames, in its own frame: blended from that at the two."""

import numpy as np

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector
from hairpipe.levelset.parts.field import PartField, part_distance
from hairpipe.levelset.parts.pose_path import Stances


@inlined
def shape_distance(before: PartField, after: PartField, changes: np.ndarray, part: int, a: float, X: Vector) -> float:
    """Return the signed distance [m] to a part, a frames after the first, at a point in its frame [m]."""
    phi = part_distance(before, part, X[0], X[1], X[2])
    if changes[part]:
        phi += a * (part_distance(after, part, X[0], X[1], X[2]) - phi)
    return phi


@inlined
def shape_gradient(before: PartField, after: PartField, changes: np.ndarray, part: int, a: float, X: Vector) -> Vector:
    """Return the gradient of the distance by central differences over one voxel, as `sample.gradient` does."""
    e, per = 0.5 / before.per_metre, before.per_metre
    gx = gy = gz = 0.0
    for side in (-1.0, 1.0):
        gx += side * per * shape_distance(before, after, changes, part, a, (X[0] + side * e, X[1], X[2]))
        gy += side * per * shape_distance(before, after, changes, part, a, (X[0], X[1] + side * e, X[2]))
        gz += side * per * shape_distance(before, after, changes, part, a, (X[0], X[1], X[2] + side * e))
    return gx, gy, gz


@inlined
def shape_change(before: PartField, after: PartField, changes: np.ndarray, part: int, X: Vector) -> float:
    """Return by how much the distance at a point of the part's frame grows over the frame [m]."""
    change = 0.0
    if changes[part]:
        change = part_distance(after, part, X[0], X[1], X[2]) - part_distance(before, part, X[0], X[1], X[2])
    return change


@inlined
def place_in(stances: Stances, t: int, part: int, x: Vector) -> Vector:
    """Return a point of the world [m] in the frame of a part, R^T (x - p)."""
    R, p = stances.turns, stances.places
    u, v, w = x[0] - p[t, part, 0], x[1] - p[t, part, 1], x[2] - p[t, part, 2]
    return (
        R[t, part, 0, 0] * u + R[t, part, 1, 0] * v + R[t, part, 2, 0] * w,
        R[t, part, 0, 1] * u + R[t, part, 1, 1] * v + R[t, part, 2, 1] * w,
        R[t, part, 0, 2] * u + R[t, part, 1, 2] * v + R[t, part, 2, 2] * w,
    )


@inlined
def turned_out(stances: Stances, t: int, part: int, g: Vector) -> Vector:
    """Return a vector in the frame of a part in the world, R g."""
    R = stances.turns
    return (
        R[t, part, 0, 0] * g[0] + R[t, part, 0, 1] * g[1] + R[t, part, 0, 2] * g[2],
        R[t, part, 1, 0] * g[0] + R[t, part, 1, 1] * g[1] + R[t, part, 1, 2] * g[2],
        R[t, part, 2, 0] * g[0] + R[t, part, 2, 1] * g[1] + R[t, part, 2, 2] * g[2],
    )


@inlined
def velocity_of(stances: Stances, t: int, part: int, x: Vector) -> Vector:
    """Return the velocity [m/s] of the part's frame at a point of the world [m], dp/dt + omega x (x - p)."""
    p, w, d = stances.places, stances.spins, stances.drifts
    u, v, z = x[0] - p[t, part, 0], x[1] - p[t, part, 1], x[2] - p[t, part, 2]
    return (
        d[t, part, 0] + w[t, part, 1] * z - w[t, part, 2] * v,
        d[t, part, 1] + w[t, part, 2] * u - w[t, part, 0] * z,
        d[t, part, 2] + w[t, part, 0] * v - w[t, part, 1] * u,
    )
