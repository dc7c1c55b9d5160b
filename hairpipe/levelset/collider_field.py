"""One level set of a whole body, with its velocities, interpolated between two frames."""
# pyright: reportCallIssue=false

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.collider import FirstHit, SdfSample, Walk, Wander
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import Vector, length, minus, row, scaled
from hairpipe.levelset.sample import (
    FAR_OUTSIDE,
    ONE_SIDED,
    Field,
    Interpolation,
    brick_at,
    departure_points,
    distance,
    distance_at,
    distance_between,
    field_of,
    gradient,
    is_far,
    normal_at,
    normal_of,
    velocity,
    velocity_at,
)
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
from hairpipe.values import LevelSet
from hairpipe.values.body import BRICK

CHUNK = 512  # points that a thread takes at a time


class Motion(NamedTuple):
    frame: float  # time between both frames [s]
    scheme: int  # an Interpolation
    speed: float  # upper bound of the speed of points of the body [m/s]
    corners: np.ndarray  # lower and upper corner of the box around the bricks of both frames [m], (2, 3) float64


class Body(NamedTuple):
    before: Field
    after: Field
    motion: Motion


@dataclass(frozen=True, eq=False)
class ColliderField:
    """A body between two frames, interpolated by one of the schemes; a Collider."""

    before: Field
    after: Field
    frame: float  # time between both frames [s]
    scheme: Interpolation
    corners: np.ndarray  # lower and upper corner of the box around the bricks of both frames [m], (2, 3) float64

    @property
    def speed(self) -> float:
        """Return an upper bound of the speed of the body [m/s], from its velocities and its change; all is read, once.

        Velocities at the frames are not sufficient for a body that rests there and moves in between.
        """
        return self._speed

    @cached_property
    def _speed(self) -> float:
        both = self.before, self.after
        known = max(fastest(field.velocity.reshape(-1, 3)) for field in both)
        return float(max(known, largest_change(*both) / self.frame, largest_change(*both[::-1]) / self.frame))

    @property
    def lost(self) -> float:
        """Return the largest displacement in the frame of what has no brick of either frame half way, or 0 [m].

        Hair passes through it: the two-sided scheme has no velocity. A lower bound: another part may have a brick.
        """
        if self.scheme != Interpolation.two_sided:
            return 0.0
        both = self.before, self.after
        return float(max(largest_loss(*both, self.frame), largest_loss(*both[::-1], -self.frame)))

    @property
    def band(self) -> float:
        """Distance beyond which the body is not found [m]."""
        return self.before.background

    def probe(self, points: np.ndarray, seconds: float, out: SdfSample, reach: np.ndarray | None = None) -> None:
        """Write the values where this body is nearer than out, in place; see Collider.

        At the end of a frame only its own level set is read.
        """
        reach = np.full(len(points), np.inf) if reach is None else reach
        if seconds == self.frame and self.scheme != ONE_SIDED:
            _probe_one(self.after, reach, points, *out)
        else:
            when = int(self.scheme), self.frame, seconds
            _probe_between(self.before, self.after, when, reach, points, *out)

    def sweep(self, walk: Walk, start: float, end: float, out: FirstHit) -> None:
        """Write hits that are sooner than out, in place; see Collider."""
        motion = Motion(self.frame, int(self.scheme), self.speed, self.corners)
        sweep_field(self.before, self.after, motion, walk, start, end, out.fraction)

    def approach(self, wander: Wander, out: np.ndarray) -> None:
        """Raise out to inf: the velocities of the frames bound no way; see Collider."""
        out[:] = np.inf


def build_collider_field(before: LevelSet, after: LevelSet, frame: float, scheme: Interpolation) -> ColliderField:
    """Build a body that moves from one level set to the next in a time [s]; shares their arrays."""
    both = (before, after)
    low = np.min([surface.origin for surface in both], axis=0)
    high = np.max([surface.origin + BRICK * surface.voxel * np.array(surface.bricks.shape) for surface in both], axis=0)
    return ColliderField(field_of(before), field_of(after), frame, scheme, np.stack([low, high]))


@njit(cache=True)
def fastest(velocities: np.ndarray) -> float:
    most = 0.0
    for i in range(len(velocities)):
        x, y, z = velocities[i, 0], velocities[i, 1], velocities[i, 2]
        most = max(most, x * x + y * y + z * z)
    return np.sqrt(most)


@inlined
def place_of(field: Field, brick: tuple[int, int, int], sample: tuple[int, int, int]) -> Vector:
    i, j, k = BRICK * brick[0] + sample[0], BRICK * brick[1] + sample[1], BRICK * brick[2] + sample[2]
    return field.x + i / field.per_metre, field.y + j / field.per_metre, field.z + k / field.per_metre


@njit(cache=True)
def largest_change(one: Field, other: Field) -> float:
    """Return by how much the distance to one body and to another differ at most [m], at every eighth sample of one."""
    most = 0.0
    for brick in np.ndindex(one.bricks.shape):
        n = one.bricks[brick]
        if n >= 0:
            for i, j, k in np.ndindex(BRICK // 2, BRICK // 2, BRICK // 2):
                x, y, z = place_of(one, brick, (2 * i, 2 * j, 2 * k))
                most = max(most, abs(distance(other, x, y, z) - one.distance[n, 2 * i, 2 * j, 2 * k]))
    return most


@njit(cache=True)
def largest_loss(one: Field, other: Field, time: float) -> float:
    """Return how far one moves in a time [s] if half way it is beyond both bands, by every eighth sample, or 0 [m]."""
    most = 0.0
    half = 0.5 * time
    for brick in np.ndindex(one.bricks.shape):
        n = one.bricks[brick]
        if n >= 0:
            for i, j, k in np.ndindex(BRICK // 2, BRICK // 2, BRICK // 2):
                # Of a thin sheet 1, rounded.
                if abs(one.distance[n, 2 * i, 2 * j, 2 * k]) * one.per_metre < 1.01:
                    v = one.velocity[n, 2 * i, 2 * j, 2 * k]
                    x, y, z = place_of(one, brick, (2 * i, 2 * j, 2 * k))
                    if is_far(one, other, x + half * v[0], y + half * v[1], z + half * v[2]):
                        most = max(most, abs(time) * length((v[0], v[1], v[2])))
    return most


@inlined
def distance_on(body: Body, ray: SpaceTimeRay, s: float) -> float:
    x, y, z = point_on(ray, s)
    motion = body.motion
    return distance_between(motion.scheme, body.before, body.after, time_on(ray, s), motion.frame, x, y, z)


@inlined
def change_along(body: Body, ray: SpaceTimeRay, s: float) -> float:
    """Return a bound of the change of the distance over a ray, from the rate at its fraction s [m].

    It is the length of the ray relative to the body, by the velocities of its frames there. Without velocities, it is
    the length of the ray plus the largest displacement of the body.
    """
    x, y, z = point_on(ray, s)
    seconds = ray.da * body.motion.frame
    before = brick_at(body.before, x, y, z) != FAR_OUTSIDE
    after = brick_at(body.after, x, y, z) != FAR_OUTSIDE
    change = 0.0
    if before:
        change = seen_from(ray, seconds, velocity(body.before, x, y, z))
    if after:  # Where both frames know the velocity, the larger change is the safe one.
        change = max(change, seen_from(ray, seconds, velocity(body.after, x, y, z)))
    if not before and not after:
        change = seen_from(ray, seconds, (0.0, 0.0, 0.0)) + body.motion.speed * seconds
    return change


@inlined
def seen_from(ray: SpaceTimeRay, seconds: float, v: Vector) -> float:
    """Return the length of a ray [m] in the frame of what moves with a velocity v [m/s]."""
    return length(minus(ray.way, scaled(seconds, v)))


@inlined
def first_hit(body: Body, ray: SpaceTimeRay, thickness: float, known: float) -> float:
    """Return the fraction of a ray at which the distance falls below the thickness [m], or inf.

    If the distance changes by at most L over a ray, and the distances at both ends, of which a sum is known, add up to
    more, it stays positive.
    """
    first, last = crossed_box(row(body.motion.corners, 0), row(body.motion.corners, 1), ray)
    if not first <= last:
        return np.inf
    change = MARGIN * max(change_along(body, ray, first), change_along(body, ray, last), STILL)
    if known - 2.0 * thickness > change:  # Decided by what the caller knows, before a distance is read.
        return np.inf
    begin, finish = distance_on(body, ray, first), distance_on(body, ray, last)
    # A point that begins nearer than its thickness hits only where it comes nearer still.
    kept = min(thickness, begin, 0.5 * body.before.background)
    if begin <= 0.0 or (finish >= kept and begin + finish - 2.0 * kept > change * (last - first)):
        return np.inf
    span = Span(last, change, 1.0 / body.before.per_metre)
    trace = traced(Trace(first, np.inf, first), span, begin - kept)
    while is_open(trace, span):
        trace = traced(trace, span, distance_on(body, ray, trace.at) - kept)
    return trace.near


@njit(cache=True, parallel=True)
def _probe_between(
    before: Field,
    after: Field,
    when: tuple[int, float, float],
    reach: np.ndarray,
    points: np.ndarray,
    nearest: np.ndarray,
    normals: np.ndarray,
    velocities: np.ndarray,
) -> None:
    """Write the sample of a body where it is nearer; it is unpacked, as a parallel loop loses writes to a member."""
    scheme, frame, seconds = when
    for chunk in prange((len(points) + CHUNK - 1) // CHUNK):
        for i in range(chunk * CHUNK, min(len(points), (chunk + 1) * CHUNK)):
            x, y, z = row(points, i)
            if is_far(before, after, x, y, z):  # Far from both: two look-ups of bricks, not of velocities.
                continue
            at = departure_points(scheme, before, after, seconds / frame, frame, x, y, z)
            phi = distance_at(before, after, at)
            if phi < nearest[i] and phi < before.background:
                nearest[i] = phi
                if phi < reach[i]:
                    normals[i, 0], normals[i, 1], normals[i, 2] = normal_at(before, after, at)
                    velocities[i, 0], velocities[i, 1], velocities[i, 2] = velocity_at(before, after, at)


@njit(cache=True, parallel=True)
def _probe_one(
    field: Field,
    reach: np.ndarray,
    points: np.ndarray,
    nearest: np.ndarray,
    normals: np.ndarray,
    velocities: np.ndarray,
) -> None:
    for chunk in prange((len(points) + CHUNK - 1) // CHUNK):
        for i in range(chunk * CHUNK, min(len(points), (chunk + 1) * CHUNK)):
            x, y, z = row(points, i)
            phi = distance(field, x, y, z)
            if phi < nearest[i] and phi < field.background:
                nearest[i] = phi
                if phi < reach[i]:
                    normals[i, 0], normals[i, 1], normals[i, 2] = normal_of(*gradient(field, x, y, z))
                    velocities[i, 0], velocities[i, 1], velocities[i, 2] = velocity(field, x, y, z)


@njit(cache=True, parallel=True)
def sweep_field(
    before: Field, after: Field, motion: Motion, walk: Walk, start: float, end: float, fraction: np.ndarray
) -> None:
    """Write, in place, hits that are sooner than `fraction`, of points that walk from a time start to end [s]."""
    count = len(walk.thickness)
    for chunk in prange((count + CHUNK - 1) // CHUNK):
        body = Body(before, after, motion)  # Made here: a parallel loop takes no tuple within a tuple.
        for i in range(chunk * CHUNK, min(count, (chunk + 1) * CHUNK)):
            if is_clear(walk, i, motion.speed * (end - start)):
                continue
            x = row(walk.before, i)
            ray = SpaceTimeRay(x, minus(row(walk.after, i), x), start / motion.frame, (end - start) / motion.frame)
            known = walk.begin[i] + walk.finish[i]
            fraction[i] = min(fraction[i], first_hit(body, ray, walk.thickness[i], known))
