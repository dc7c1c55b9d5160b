"""A body in parts between two frames: each part moves along its bone's path, with a blended shape.

    phi(x, a) = min_k f_k(R_k(a)^T (x - p_k(a)), a),   f_k(X, a) = (1 - a) phi_k0(X) + a phi_k1(X)
    v = dp/dt + omega x (x - p) + u n,   u = (phi_k0 - phi_k1) / (dt |grad f_k|)

A part of constant shape is read once.

We differ from the paper (Selle et al. 2008, section 5), which blends one level set of the whole body along its mean
velocity: this needs no velocities, preserves the shape of rotating parts, and does not mix two close bodies.

Poses follow a smooth path

    R(a) = R_0 exp(q(a)),  q = h10 w0 + h01 r + h11 J(r)^-1 w1,  p(a) = p_0 + h10 v0 + h01 (p_1 - p_0) + h11 v1

with r = log(R_0^T R_1), the velocities v and w (in the part's own frame) of the key poses times the frame, the right
Jacobian J, see `rotations`, and Hermite's h10 = a^3 - 2 a^2 + a, h01 = 3 a^2 - 2 a^3, h11 = a^3 - a^2. Poses and
velocities at the frames are the given ones, independent of other frames: the path is C1. A rotation by half a circle
per frame is ambiguous: the shorter one is used.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.collider import FirstHit, SdfSample, Walk, Wander
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.rotations import exponential, inverse_jacobian, jacobian, logarithm
from hairpipe.geometry.vec3 import Vector, length, minus, mix, row
from hairpipe.levelset.sphere_tracing import (
    MARGIN,
    STILL,
    SpaceTimeRay,
    Span,
    Trace,
    crossed_box,
    is_clear,
    is_open,
    point_on,
    time_on,
    traced,
)
from hairpipe.values import BodyParts, LevelSet
from hairpipe.values.body import BRICK


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
def distance_and_change(shape: Shape, a: float, X: Vector) -> tuple[float, float]:
    """Return the distance to a part, as `shape_distance` does, and by how much it grows over the frame [m]."""
    phi = part_distance(shape.before, shape.part, X)
    change = 0.0
    if shape.changes[shape.part]:
        change = part_distance(shape.after, shape.part, X) - phi
    return phi + a * change, change


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


class Outlines(NamedTuple):
    """Outlines of G parts in their own frames."""

    changes: np.ndarray  # whether the shape of a part differs between the frames, (G,) bool
    low: np.ndarray  # lower corner of the box around a part [m], (G, 3) float64
    high: np.ndarray  # upper corner [m]


@inlined
def distance_on(shape: Shape, ray: SpaceTimeRay, s: float) -> float:
    return shape_distance(shape, time_on(ray, s), point_on(ray, s))


@inlined
def swelling_along(shape: Shape, ray: SpaceTimeRay, first: float, last: float) -> float:
    """Return how much the part's change of shape changes the distance over a ray, as at two fractions of it [m]."""
    before, after = shape_change(shape, point_on(ray, first)), shape_change(shape, point_on(ray, last))
    return max(abs(before) * ray.da, abs(after) * ray.da)


@inlined
def first_hit(shape: Shape, ray: SpaceTimeRay, low: Vector, high: Vector, kept: float) -> float:
    """Return the fraction of a ray in a part's frame at which the distance falls below `kept` [m], or inf.

    If the distance changes by at most L over a ray, and the distances at both ends add up to more, it stays positive.
    """
    first, last = crossed_box(low, high, ray)
    if not first <= last:
        return np.inf
    gap, finish = distance_on(shape, ray, first) - kept, distance_on(shape, ray, last) - kept
    change = MARGIN * max(length(ray.way) + swelling_along(shape, ray, first, last), STILL)
    if finish >= 0.0 and gap + finish > change * (last - first):
        return np.inf
    span = Span(last, change, 1.0 / shape.before.per_metre)
    trace = traced(Trace(first, np.inf, first), span, gap)
    while is_open(trace, span):
        trace = traced(trace, span, distance_on(shape, ray, trace.at) - kept)
    return trace.near


@inlined
def meets_box(boxes: np.ndarray, part: int, x: Vector, y: Vector) -> bool:
    meets = True
    for axis in range(3):
        meets = (
            meets and min(x[axis], y[axis]) <= boxes[part, 1, axis] and max(x[axis], y[axis]) >= boxes[part, 0, axis]
        )
    return meets


@inlined
def first_hit_on_path(
    shape: Shape, outlines: Outlines, part_poses: PartPoses, x: Vector, y: Vector, kept: float, soonest: float
) -> float:
    """Return the fraction of the way from x to y at which a part that moves gets nearer than `kept` [m], if sooner."""
    times = part_poses.times
    legs = len(part_poses.times) - 1
    low, high = row(outlines.low, shape.part), row(outlines.high, shape.part)
    end = place_in(part_poses, 0, shape.part, x)
    for t in range(legs):
        if t / legs >= soonest:  # Another part was hit before this leg begins.
            break
        start = end
        end = place_in(part_poses, t + 1, shape.part, mix(x, y, (t + 1) / legs))
        ray = SpaceTimeRay(start, minus(end, start), times[t], times[t + 1] - times[t])
        found = first_hit(shape, ray, low, high, kept)
        if found < np.inf:
            return min(soonest, (t + found) / legs)  # Legs follow each other in time: the first hit is the soonest.
    return soonest


@njit(cache=True)
def legs_between(part_poses: PartPoses) -> np.ndarray:
    """Return how far points get in the frames of G parts from one of T times to the next, (G, T - 1, 3, 7); pure.

    A point that moves straight from x to y in all of the time gets there by M [x, y, 1] [m].
    """
    legs = len(part_poses.times) - 1
    parts = part_poses.places.shape[1]
    out = np.empty((parts, legs, 3, 7))
    for part in range(parts):
        for t in range(legs):
            R0 = part_poses.turns[t, part].T
            R1 = part_poses.turns[t + 1, part].T
            a = t / legs
            b = (t + 1) / legs
            out[part, t, :, :3] = (1.0 - b) * R1 - (1.0 - a) * R0
            out[part, t, :, 3:6] = b * R1 - a * R0
            out[part, t, :, 6] = R0 @ part_poses.places[t, part] - R1 @ part_poses.places[t + 1, part]
    return out


@inlined
def way_past(legs: np.ndarray, part: int, x: Vector, y: Vector) -> float:
    """Return how long the path from x to y is in the frame of a part, leg by leg: with the part's own turning [m]."""
    way = 0.0
    for t in range(legs.shape[1]):
        squared = 0.0
        for c in range(3):
            M = legs[part, t, c]
            gone = M[0] * x[0] + M[1] * x[1] + M[2] * x[2] + M[3] * y[0] + M[4] * y[1] + M[5] * y[2] + M[6]
            squared += gone * gone
        way += np.sqrt(squared)
    return way


@inlined
def stays_clear(shape: Shape, part_poses: PartPoses, x: Vector, y: Vector, way: float, kept: float) -> bool:
    """Return whether the path from x to y in the frame of a part is too short to get nearer than `kept` [m]."""
    times = part_poses.times
    legs = len(part_poses.times) - 1
    start = place_in(part_poses, 0, shape.part, x)
    end = place_in(part_poses, legs, shape.part, y)
    before, earlier = distance_and_change(shape, times[0], start)
    after, later = distance_and_change(shape, times[legs], end)
    swelling = max(abs(earlier), abs(later)) * (times[legs] - times[0])
    return after >= kept and before + after - 2.0 * kept > MARGIN * (way + swelling)


@njit(cache=True, parallel=True)
def sweep_parts(
    before: PartField,
    after: PartField,
    outlines: Outlines,
    part_poses: PartPoses,
    boxes: np.ndarray,
    walk: Walk,
    changes: tuple[float, np.ndarray],
    fraction: np.ndarray,
) -> None:
    """Write the hits before `fraction` of points that move from the first of the times to the last, in place.

    boxes    boxes around the parts in the world at all these times [m], (G, 2, 3)
    changes  longest displacement of a part [m], and how much the shape of each changes its distance [m], (G,)
    """
    count = len(walk.thickness)
    farthest, swelling = changes
    legs = legs_between(part_poses)
    most = 0.5 * before.background
    for chunk in prange((count + CHUNK - 1) // CHUNK):
        for i in range(chunk * CHUNK, min(count, (chunk + 1) * CHUNK)):
            if is_clear(walk, i, farthest):
                continue
            x, y = row(walk.before, i), row(walk.after, i)
            known = walk.begin[i] + walk.finish[i] - 2.0 * walk.thickness[i]
            kept = -1.0
            for part in range(len(swelling)):
                if not meets_box(boxes, part, x, y):
                    continue
                way = way_past(legs, part, x, y)
                if known > MARGIN * (way + swelling[part]):  # As in `is_clear`, by the way that this part sees.
                    continue
                if kept < 0.0:
                    kept = min(walk.thickness[i], most)
                    if not walk.begin[i] > kept:  # It may begin nearer than what it keeps.
                        _, phi = nearest_part(before, after, outlines.changes, part_poses, boxes, x)
                        kept = min(kept, phi)
                        if phi <= 0.0:  # It begins inside: to come out is not a hit.
                            break
                shape = Shape(before, after, outlines.changes, part)
                if not stays_clear(shape, part_poses, x, y, way, kept):
                    fraction[i] = first_hit_on_path(shape, outlines, part_poses, x, y, kept, fraction[i])


@njit(cache=True, parallel=True)
def raise_ways(legs: np.ndarray, boxes: np.ndarray, swelling: np.ndarray, wander: Wander, out: np.ndarray) -> None:
    """Raise out to the ways of points in the frames of the parts whose boxes they are in now [m], (n,), in place.

    legs      from then to now, see `legs_between`
    boxes     boxes around the parts in the world now [m], (G, 2, 3)
    swelling  how much the shape of each part changes its distance [m], (G,)
    """
    for k in prange(len(out)):
        x, y = row(wander.before, wander.which[k]), row(wander.after, wander.which[k])
        for part in range(len(swelling)):
            if is_within(boxes, part, y):  # Beyond its box a part is no nearer than the border of the band.
                out[k] = max(out[k], way_past(legs, part, x, y) + swelling[part])


# A part turns by no more than this from a sample of its pose to the next [rad], between which its points move straight.
FINE = 0.02
MOST_LOOKS = 64
_LOOKS = 5  # samples of a frame in which its fastest moment is looked for


@dataclass(frozen=True, eq=False)
class ColliderParts:
    """A body in parts between two frames; a Collider."""

    before: PartField
    after: PartField
    outlines: Outlines
    path: PosePath

    @property
    def speed(self) -> float:
        """Return an upper bound of the speed of parts [m/s]: of the fastest corner of a box, plus that of its shape.

        The corners are sampled at a few times, v + omega x (x - p).
        """
        return self._speed

    @cached_property
    def _speed(self) -> float:
        part_poses = part_poses_at(self.path, np.linspace(0.0, self.path.frame, _LOOKS))
        corners = np.stack(np.meshgrid(*3 * [[False, True]], indexing="ij"), axis=-1).reshape(-1, 3)
        arms = np.einsum(
            "tkxy,cky->ctkx", part_poses.turns, np.where(corners[:, None], self.outlines.high, self.outlines.low)
        )
        advected = np.linalg.norm(part_poses.drifts + np.cross(part_poses.spins, arms), axis=-1)
        return float((advected + self.swelling).max(initial=0.0))

    @cached_property
    def swelling(self) -> np.ndarray:
        """Speed of the shape of every part in its own frame [m/s], |phi_1 - phi_0| / dt where that is largest, (G,)."""
        return largest_changes(self.before, self.after, self.outlines.changes) / self.path.frame

    @property
    def band(self) -> float:
        """Distance beyond which the body is not found [m]."""
        return self.before.background

    def probe(self, points: np.ndarray, seconds: float, out: SdfSample, reach: np.ndarray | None = None) -> None:
        """Write what is nearer than out, in place; see Collider."""
        reach = np.full(len(points), np.inf) if reach is None else reach
        part_poses = part_poses_at(self.path, np.array([seconds]))
        parts = PartsQuery(self.outlines.changes, boxes_at(part_poses, self.outlines), self.path.frame, reach)
        probe_parts(self.before, self.after, part_poses, parts, points, *out)

    def sweep(self, walk: Walk, start: float, end: float, out: FirstHit) -> None:
        """Write hits that are sooner than out, in place; see Collider."""
        part_poses = part_poses_at(self.path, self.looks(start, end))
        boxes = boxes_at(part_poses, self.outlines)
        changes = self.speed * (end - start), self.swelling * (end - start)
        sweep_parts(self.before, self.after, self.outlines, part_poses, boxes, walk, changes, out.fraction)

    def approach(self, wander: Wander, out: np.ndarray) -> None:
        """Raise out to the ways of points relative to this body, in place; see Collider."""
        part_poses = part_poses_at(self.path, np.array([wander.then, wander.now]))
        boxes = boxes_at(part_poses_at(self.path, np.array([wander.now])), self.outlines)
        raise_ways(legs_between(part_poses), boxes, self.swelling * abs(wander.now - wander.then), wander, out)

    def looks(self, start: float, end: float) -> np.ndarray:
        """Return even times from start to end [s] between which no part turns much, (T,)."""
        spins = part_poses_at(self.path, np.array([start, 0.5 * (start + end), end])).spins
        turn = np.sqrt((spins**2).sum(axis=2)).max() * (end - start)
        return np.linspace(start, end, 1 + min(MOST_LOOKS, 1 + int(turn / FINE)))


def build_collider_parts(before: BodyParts, after: BodyParts, frame: float) -> ColliderParts:
    """Build a body that moves from one frame to the next in a time [s]; BadInput if the frames have different parts."""
    if before.names != after.names or before.voxel != after.voxel or before.half_width != after.half_width:
        right = "parts baked from one body with the same settings"
        raise BadInput("the parts of the body are not the same at both frames", where="parts", right=right)
    low = np.minimum(before.origins, after.origins)
    highs = [parts.origins + BRICK * parts.voxel * parts.shapes for parts in (before, after)]
    path = path_between(before.poses, before.rates, after.poses, after.rates, frame)
    changes = np.array([not is_same(before, after, part) for part in range(len(before.names))])
    outlines = Outlines(changes, low, np.maximum(*highs))
    return ColliderParts(part_field_of(before), part_field_of(after), outlines, path)


def is_same(before: BodyParts, after: BodyParts, part: int) -> bool:
    """Return whether a part has the same samples in both frames, in bricks counted from its first."""
    if not np.array_equal(before.origins[part], after.origins[part]):
        return False
    if not np.array_equal(before.shapes[part], after.shapes[part]):
        return False
    samples = []
    for parts in (before, after):
        index = parts.bricks[parts.starts[part] : parts.starts[part + 1]]
        count = int((index >= 0).sum())
        first = int(index[index >= 0].min()) if count else 0
        samples.append((np.where(index >= 0, index - first, index), parts.distance[first : first + count]))
    return all(np.array_equal(*both) for both in zip(*samples, strict=True))


@njit(cache=True)
def boxes_at(part_poses: PartPoses, outlines: Outlines) -> np.ndarray:
    """Return low and high corner, in the world, of the box around every part at all times together [m], (G, 2, 3)."""
    low, high = outlines.low, outlines.high
    boxes = np.empty((len(low), 2, 3))
    boxes[:, 0], boxes[:, 1] = np.inf, -np.inf
    for t in range(len(part_poses.turns)):
        for k in range(len(low)):
            for x in range(3):
                middle = part_poses.places[t, k, x]
                half = 0.0
                for y in range(3):
                    turn = part_poses.turns[t, k, x, y]
                    middle += 0.5 * turn * (low[k, y] + high[k, y])
                    # The box around a turned box: its half edges are those of the part times |R|.
                    half += 0.5 * abs(turn) * (high[k, y] - low[k, y])
                boxes[k, 0, x] = min(boxes[k, 0, x], middle - half)
                boxes[k, 1, x] = max(boxes[k, 1, x], middle + half)
    return boxes
