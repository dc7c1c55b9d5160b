"""One level set of a whole body, with its velocities, interpolated between two frames."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.data import LevelSet
from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector
from hairpipe.levelset.boxes import passage
from hairpipe.levelset.collider import Probe, Sweep
from hairpipe.levelset.grid_layout import BRICK
from hairpipe.levelset.interpolation import Interpolation, distance_between, evaluate
from hairpipe.levelset.sample import FAR_OUTSIDE, Field, brick_at, field_of, velocity

CHUNK = 512
"""Points that a thread takes at a time."""
# How much faster the body may pass between the ends of a path, where its velocity is known, than at them.
MARGIN = 1.25
# Of the spacing of samples: how far a point moves at least from look to look, and how well a meeting is known.
LEAST, SHARP = 1e-2, 1e-5
# [m]; a way as short as this is no way.
STILL = 1e-12


class MovingField(NamedTuple):
    """A body between two frames, interpolated after one of the schemes; a MovingSurface.

    before, after  the body at the two frames
    frame          time between them [s]
    scheme         an Interpolation
    speed          no point of the body is faster [m/s]
    low, high      corners of the box around the bricks of both frames [m], (3,) float64
    """

    before: Field
    after: Field
    frame: float
    scheme: int
    speed: float
    low: np.ndarray
    high: np.ndarray

    def probe(self, points: np.ndarray, seconds: float, out: Probe) -> None:
        """Write what is nearer than out, in place; see MovingSurface."""
        probe_field(self.before, self.after, self.frame, self.scheme, seconds, points, *out)

    def sweep(
        self, before: np.ndarray, after: np.ndarray, start: float, end: float, thickness: np.ndarray, out: Sweep
    ) -> None:
        """Write meetings that are sooner than out, in place; see MovingSurface."""
        sweep_field(*self, start, end, before, after, thickness, out.fraction)


def moving_field(before: LevelSet, after: LevelSet, frame: float, scheme: Interpolation) -> MovingField:
    """Make a body that moves from one level set to the next; their arrays are shared.

    frame  time between them [s]
    """
    both = (before, after)
    speed = max(fastest(surface.velocity.reshape(-1, 3)) for surface in both)
    low = np.min([surface.origin for surface in both], axis=0)
    high = np.max([surface.origin + BRICK * surface.voxel * np.array(surface.bricks.shape) for surface in both], axis=0)
    return MovingField(field_of(before), field_of(after), frame, int(scheme), float(speed), low, high)


@njit(cache=True)
def fastest(velocities: np.ndarray) -> float:
    """Return the largest length of vectors (n, 3)."""
    most = 0.0
    for i in range(len(velocities)):
        x, y, z = velocities[i, 0], velocities[i, 1], velocities[i, 2]
        most = max(most, x * x + y * y + z * z)
    return np.sqrt(most)


class Course(NamedTuple):
    """A straight way through space and time.

    x, y, z     where it begins [m]
    dx, dy, dz  how far it goes [m]
    a           when it begins, since the first frame [frames]
    da          how long it takes [frames]
    """

    x: float
    y: float
    z: float
    dx: float
    dy: float
    dz: float
    a: float
    da: float


@inlined
def distance_on(body: MovingField, way: Course, s: float) -> float:
    """Return the distance [m] to the body at a fraction s of a way."""
    x, y, z = way.x + s * way.dx, way.y + s * way.dy, way.z + s * way.dz
    return distance_between(body.scheme, body.before, body.after, way.a + s * way.da, body.frame, x, y, z)


@inlined
def change_along(body: MovingField, way: Course, s: float) -> float:
    """Return by how much the distance may change over a way, at the pace it has at its fraction s [m].

    That is the length of the way as the body sees it, by the velocity that its frames have there. Where they have none,
    it is the length of the way and the farthest that the body goes meanwhile.
    """
    x, y, z = way.x + s * way.dx, way.y + s * way.dy, way.z + s * way.dz
    seconds = way.da * body.frame
    before = brick_at(body.before, x, y, z) != FAR_OUTSIDE
    after = brick_at(body.after, x, y, z) != FAR_OUTSIDE
    change = 0.0
    if before:
        change = seen_from(way, seconds, velocity(body.before, x, y, z))
    if after:
        change = max(change, seen_from(way, seconds, velocity(body.after, x, y, z)))
    if not before and not after:
        change = seen_from(way, seconds, (0.0, 0.0, 0.0)) + body.speed * seconds
    return change


@inlined
def seen_from(way: Course, seconds: float, v: Vector) -> float:
    """Return how long a way is [m] as seen from what moves with a velocity v [m/s]."""
    dx, dy, dz = way.dx - seconds * v[0], way.dy - seconds * v[1], way.dz - seconds * v[2]
    return np.sqrt(dx * dx + dy * dy + dz * dz)


@inlined
def meeting(body: MovingField, way: Course, thickness: float) -> float:
    """Return the fraction of a way at which the distance gets below the thickness [m], or inf.

    Sphere tracing (Hart 1996): the distance tells how far on the body cannot be. Along a way over which it changes by
    at most L, it cannot get below zero if the distances at both ends add up to more than L.
    """
    low, high = (body.low[0], body.low[1], body.low[2]), (body.high[0], body.high[1], body.high[2])
    first, last = passage(low, high, (way.x, way.y, way.z), (way.dx, way.dy, way.dz))
    if not first <= last:
        return np.inf
    begin, finish = distance_on(body, way, first), distance_on(body, way, last)
    kept = min(thickness, begin, 0.5 * body.before.background)
    most = MARGIN * max(change_along(body, way, first), change_along(body, way, last), STILL)
    if begin <= 0.0 or (finish >= kept and begin + finish - 2.0 * kept > most * (last - first)):
        return np.inf
    voxel = 1.0 / body.before.per_metre
    near, far, gap = first, first, begin - kept
    while gap >= 0.0:
        if far == last:
            return np.inf
        near, far = far, min(last, far + max(gap, LEAST * voxel) / most)
        gap = distance_on(body, way, far) - kept
    while (far - near) * most > SHARP * voxel:
        middle = 0.5 * (near + far)
        if distance_on(body, way, middle) < kept:
            far = middle
        else:
            near = middle
    return near


@njit(cache=True, parallel=True)
def probe_field(
    before: Field,
    after: Field,
    frame: float,
    scheme: int,
    seconds: float,
    points: np.ndarray,
    distance: np.ndarray,
    normal: np.ndarray,
    velocity: np.ndarray,
) -> None:
    """Write, in place, what the body is like where it is nearer than `distance`; a Probe, unpacked."""
    for chunk in prange((len(points) + CHUNK - 1) // CHUNK):
        for i in range(chunk * CHUNK, min(len(points), (chunk + 1) * CHUNK)):
            x, y, z = points[i, 0], points[i, 1], points[i, 2]
            phi = distance_between(scheme, before, after, seconds / frame, frame, x, y, z)
            if phi < distance[i] and phi < before.background:
                _, nx, ny, nz, vx, vy, vz = evaluate(scheme, before, after, seconds / frame, frame, x, y, z)
                distance[i] = phi
                normal[i, 0], normal[i, 1], normal[i, 2] = nx, ny, nz
                velocity[i, 0], velocity[i, 1], velocity[i, 2] = vx, vy, vz


@njit(cache=True, parallel=True)
def sweep_field(
    before: Field,
    after: Field,
    frame: float,
    scheme: int,
    speed: float,
    low: np.ndarray,
    high: np.ndarray,
    start: float,
    end: float,
    begin: np.ndarray,
    finish: np.ndarray,
    thickness: np.ndarray,
    fraction: np.ndarray,
) -> None:
    """Write, in place, meetings that are sooner than `fraction`; a MovingField and a Sweep, unpacked."""
    for chunk in prange((len(begin) + CHUNK - 1) // CHUNK):
        body = MovingField(before, after, frame, scheme, speed, low, high)
        for i in range(chunk * CHUNK, min(len(begin), (chunk + 1) * CHUNK)):
            x, y, z = begin[i, 0], begin[i, 1], begin[i, 2]
            dx, dy, dz = finish[i, 0] - x, finish[i, 1] - y, finish[i, 2] - z
            way = Course(x, y, z, dx, dy, dz, start / frame, (end - start) / frame)
            fraction[i] = min(fraction[i], meeting(body, way, thickness[i]))
