"""The parts of a body as kernels see them, each read in its own frame, and their poses between two frames.

The shape of a part between two frames is blended, in its own frame, from that at the two. Poses follow a smooth path

    R(a) = R_0 exp(q(a)),  q = h10 w0 + h01 r + h11 J(r)^-1 w1,  p(a) = p_0 + h10 v0 + h01 (p_1 - p_0) + h11 v1

with r = log(R_0^T R_1), the velocities v and w (in the part's own frame) of the key poses times the frame, the right
Jacobian J, see `rotations`, and Hermite's h10 = a^3 - 2 a^2 + a, h01 = 3 a^2 - 2 a^3, h11 = a^3 - a^2. Poses and
velocities at the frames are the given ones, independent of other frames: the path is C1. A rotation by half a circle
per frame is ambiguous: the shorter one is used.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.body.rotations import exponential, inverse_jacobian, jacobian, logarithm
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import Vector, length, row
from hairpipe.levelset.grid_layout import BRICK
from hairpipe.values import BodyParts, LevelSet


class PosePath(NamedTuple):
    """The paths of G parts."""

    turns: np.ndarray  # R_0, (G, 3, 3)
    places: np.ndarray  # p_0 [m], (G, 3)
    vectors: np.ndarray  # w0, r, J(r)^-1 w1 [rad], (3, G, 3)
    ways: np.ndarray  # v0, p_1 - p_0, v1 [m], (3, G, 3)
    frame: float  # [s]


class PartPoses(NamedTuple):
    """Poses and velocities of G parts at T times."""

    times: np.ndarray  # since the first frame [frames], (T,)
    turns: np.ndarray  # R, (T, G, 3, 3)
    places: np.ndarray  # p [m], (T, G, 3)
    spins: np.ndarray  # angular velocity in the world [rad/s], (T, G, 3)
    drifts: np.ndarray  # velocity of p [m/s], (T, G, 3)


def path_between(pose0: np.ndarray, rate0: np.ndarray, pose1: np.ndarray, rate1: np.ndarray, frame: float) -> PosePath:
    """Return the paths from one frame to the next; pure.

    pose0, pose1  [R | p] at the frames [m], (G, 3, 4);  rate0, rate1  their time derivatives
    frame         time between them [s]
    """
    vectors = np.empty((3, len(pose0), 3))
    for k in range(len(pose0)):
        start, end = pose0[k, :, :3], pose1[k, :, :3]
        vectors[0, k] = frame * spin_within(start, rate0[k, :, :3])
        vectors[1, k] = logarithm(start.T @ end)
        vectors[2, k] = frame * inverse_jacobian(vectors[1, k]) @ spin_within(end, rate1[k, :, :3])
    ways = np.stack([frame * rate0[:, :, 3], pose1[:, :, 3] - pose0[:, :, 3], frame * rate1[:, :, 3]])
    turns = np.ascontiguousarray(pose0[:, :, :3])
    places = np.ascontiguousarray(pose0[:, :, 3])
    return PosePath(turns, places, vectors, ways, frame)


def spin_within(turn: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Return the angular velocity in its own frame [rad/s], (3,), of a rotation and its rate, (3, 3) each.

    Only the antisymmetric part of R^T dR/dt is used: a rate from finite differences also contains a small stretch.
    """
    W = turn.T @ rate
    return 0.5 * np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]])


@njit(cache=True)
def part_poses_at(path: PosePath, times: np.ndarray) -> PartPoses:
    """Return the parts at times since the first frame [s], (T,); pure."""
    count = len(times)
    parts = len(path.places)
    turns = np.empty((count, parts, 3, 3))
    places, spins, drifts = np.empty((count, parts, 3)), np.empty((count, parts, 3)), np.empty((count, parts, 3))
    found = PartPoses(np.empty(count), turns, places, spins, drifts)
    for t in range(count):
        a = times[t] / path.frame
        found.times[t] = a
        h = (a * (1.0 - a) ** 2, a * a * (3.0 - 2.0 * a), a * a * (a - 1.0))
        d = ((1.0 - a) * (1.0 - 3.0 * a), 6.0 * a * (1.0 - a), a * (3.0 * a - 2.0))
        for k in range(parts):
            vectors, ways = path.vectors[:, k], path.ways[:, k]
            q = h[0] * vectors[0] + h[1] * vectors[1] + h[2] * vectors[2]
            dq = d[0] * vectors[0] + d[1] * vectors[1] + d[2] * vectors[2]
            R = path.turns[k] @ exponential(q)
            found.turns[t, k] = R
            found.spins[t, k] = R @ (jacobian(q) @ dq) / path.frame
            found.places[t, k] = path.places[k] + h[0] * ways[0] + h[1] * ways[1] + h[2] * ways[2]
            found.drifts[t, k] = (d[0] * ways[0] + d[1] * ways[1] + d[2] * ways[2]) / path.frame
    return found


FAR_OUTSIDE = LevelSet.FAR_OUTSIDE


class PartField(NamedTuple):
    """The arrays and numbers of BodyParts, without their poses.

    starts, shapes, origins, bricks, distance, inner  as in BodyParts
    """

    starts: np.ndarray
    shapes: np.ndarray
    origins: np.ndarray
    bricks: np.ndarray
    distance: np.ndarray
    inner: np.ndarray
    corners: np.ndarray  # start of the corners of every part in `inner`, (G,) int64
    per_metre: float  # samples per metre [1/m]
    background: float  # distance beyond the band, outside [m]


def part_field_of(parts: BodyParts) -> PartField:
    """Return the parts for use in kernels; their arrays are shared, not copied."""
    # Rounded as the samples are, so that the distance does not jump where the bricks end.
    background = float(np.float32(parts.voxel * parts.half_width))
    counts = np.prod(parts.shapes.astype(np.int64) + 1, axis=1)
    arrays = (parts.starts, parts.shapes, parts.origins, parts.bricks, parts.distance, parts.inner)
    return PartField(*arrays, np.cumsum(counts) - counts, 1 / parts.voxel, background)


@inlined
def part_distance(field: PartField, part: int, X: Vector) -> float:
    """Return the signed distance to a part [m] at a point in its frame [m]; far outside that of the band's border."""
    na, nb, nc = field.shapes[part, 0], field.shapes[part, 1], field.shapes[part, 2]
    u = (X[0] - field.origins[part, 0]) * field.per_metre
    v = (X[1] - field.origins[part, 1]) * field.per_metre
    w = (X[2] - field.origins[part, 2]) * field.per_metre
    phi = field.background
    if 0.0 <= u < 8.0 * na and 0.0 <= v < 8.0 * nb and 0.0 <= w < 8.0 * nc:
        i, j, k = int(u), int(v), int(w)
        n = field.bricks[field.starts[part] + ((i >> 3) * nb + (j >> 3)) * nc + (k >> 3)]
        if n >= 0:
            phi = between_samples(field.distance, n, (i & 7, j & 7, k & 7), (u - i, v - j, w - k))
        elif n != FAR_OUTSIDE:
            phi = between_corners(field, part, u, v, w)
    return phi


@inlined
def between_corners(field: PartField, part: int, u: float, v: float, w: float) -> float:
    """Return the signed distance [m] far inside a part, (u, v, w) samples from its first: that of a block's corners."""
    d = field.inner
    nb = field.shapes[part, 1] + 1
    nc = field.shapes[part, 2] + 1
    a, b, c = int(u) >> 3, int(v) >> 3, int(w) >> 3
    f, g, h = 0.125 * u - a, 0.125 * v - b, 0.125 * w - c
    n = field.corners[part] + (a * nb + b) * nc + c
    m = n + nb * nc
    c00 = d[n] + f * (d[m] - d[n])
    c01 = d[n + 1] + f * (d[m + 1] - d[n + 1])
    c10 = d[n + nc] + f * (d[m + nc] - d[n + nc])
    c11 = d[n + nc + 1] + f * (d[m + nc + 1] - d[n + nc + 1])
    low, high = c00 + g * (c10 - c00), c01 + g * (c11 - c01)
    return low + h * (high - low)


@inlined
def between_samples(d: np.ndarray, n: int, voxel: tuple[int, int, int], fractions: Vector) -> float:
    """Return the samples d of brick n, blended in a voxel at fractions of its edges."""
    (i, j, k), (f, g, h) = voxel, fractions
    c00 = d[n, i, j, k] + f * (d[n, i + 1, j, k] - d[n, i, j, k])
    c01 = d[n, i, j, k + 1] + f * (d[n, i + 1, j, k + 1] - d[n, i, j, k + 1])
    c10 = d[n, i, j + 1, k] + f * (d[n, i + 1, j + 1, k] - d[n, i, j + 1, k])
    c11 = d[n, i, j + 1, k + 1] + f * (d[n, i + 1, j + 1, k + 1] - d[n, i, j + 1, k + 1])
    low, high = c00 + g * (c10 - c00), c01 + g * (c11 - c01)
    return low + h * (high - low)


class Shape(NamedTuple):
    """Shape of a part between two frames."""

    before: PartField
    after: PartField
    changes: np.ndarray  # whether the shape of a part differs in the second frame, (G,) bool
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
    e = 0.5 / shape.before.per_metre  # central differences over one voxel, as those of `sample.gradient`
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


CHUNK = 512  # points that a thread takes at a time
# Least slope of a distance: half way between two sheets, where it is flatter, it does not give the shape's own speed.
STEEP = 0.5


@inlined
def is_within(boxes: np.ndarray, part: int, x: Vector) -> bool:
    inside = boxes[part, 0, 0] <= x[0] <= boxes[part, 1, 0] and boxes[part, 0, 1] <= x[1] <= boxes[part, 1, 1]
    return inside and boxes[part, 0, 2] <= x[2] <= boxes[part, 1, 2]


@inlined
def nearest_part(
    before: PartField, after: PartField, changes: np.ndarray, part_poses: PartPoses, boxes: np.ndarray, x: Vector
) -> tuple[int, float]:
    """Return the part nearest to a point at the first of the times, -1 where none is in reach, and its distance [m]."""
    found = -1
    nearest = before.background
    for part in range(len(changes)):
        if is_within(boxes, part, x):  # Beyond its box a part is no nearer than the border of the band.
            shape = Shape(before, after, changes, part)
            phi = shape_distance(shape, part_poses.times[0], place_in(part_poses, 0, part, x))
            if phi < nearest:
                found, nearest = part, phi
    return found, nearest


class PartsQuery(NamedTuple):
    """Data of G parts at one time for a query."""

    changes: np.ndarray  # whether the shape of a part differs in the second frame, (G,) bool
    boxes: np.ndarray  # boxes around the parts in the world [m], (G, 2, 3)
    frame: float  # time between the frames [s]
    reach: np.ndarray  # distance from which on only the distance of a point is queried [m], (P,)


@njit(cache=True, parallel=True)
def probe_parts(
    before: PartField,
    after: PartField,
    part_poses: PartPoses,
    parts: PartsQuery,
    points: np.ndarray,
    distance: np.ndarray,
    normal: np.ndarray,
    velocity: np.ndarray,
) -> None:
    """Write the sample of the body where it is nearer than `distance`, in place; a SdfSample, unpacked."""
    changes, boxes, frame, reach = parts.changes, parts.boxes, parts.frame, parts.reach
    for chunk in prange((len(points) + CHUNK - 1) // CHUNK):
        for i in range(chunk * CHUNK, min(len(points), (chunk + 1) * CHUNK)):
            x = row(points, i)
            part, phi = nearest_part(before, after, changes, part_poses, boxes, x)
            if part < 0 or not phi < distance[i]:  # Written so that a NaN is not nearer.
                continue
            distance[i] = phi
            if not phi < reach[i]:  # Normal and velocity cost more, and are asked for within reach only.
                continue
            shape = Shape(before, after, changes, part)
            X = place_in(part_poses, 0, part, x)
            g = turned_out(part_poses, 0, part, shape_gradient(shape, part_poses.times[0], X))
            steep = length(g)
            scale = 1.0 / steep if steep > 0.0 else 0.0
            # u = (phi_0 - phi_1) / (dt |grad f|) along the normal; the slope is bounded, see `STEEP`.
            swell = -shape_change(shape, X) / (frame * max(steep, STEEP)) * scale
            advected = velocity_of(part_poses, 0, part, x)
            for axis in range(3):
                normal[i, axis] = scale * g[axis]
                velocity[i, axis] = advected[axis] + swell * g[axis]
