"""Contact of particles with bodies: half-spaces for the steps of a frame, and a correction at its end.

Bodies are queried once at the predicted positions of particles at the end of the frame, which gives a plane for each
that moves with the body. A step keeps the distance from the plane: along the normal n a particle that would come nearer
than its thickness moves with

    n . v = n . v_b + min((thickness - gap) / dt, 0.5 m/s)

within the solve, so that links are coupled to contact; a particle is held if it would come too near with unchanged
links. Friction, mu times the contact force, is a damper in the solve. Errors of the planes are corrected by a second
query at the end, where particles are moved out and lose their inward velocity.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.geometry.collider import Collider, SdfSample
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import dot, flattened, length, minus, plus, row, scaled
from hairpipe.laws.coulomb import coulomb, slide
from hairpipe.particles.model import Moving
from hairpipe.particles.solve import hold, product, take_off

PUSH_OUT = 0.5
"""Speed at which a particle that is too near is moved out [m/s]."""
CREEP = 1e-4
"""Speed at which what does not slide gives way [m/s]."""


class Planes(NamedTuple):
    """Contact planes of bodies near particles.

    normals    unit, outward; 0 without a body, (N, 3)
    offsets    gap of a point x at the end of the frame is n . x + offset [m], (N,)
    drifts     velocity of the body there [m/s], (N, 3)
    thickness  contact distance of particles [m], (N,)
    friction   Coulomb coefficient
    """

    normals: np.ndarray
    offsets: np.ndarray
    drifts: np.ndarray
    thickness: np.ndarray
    friction: float


def look(
    bodies: Sequence[Collider], points: np.ndarray, seconds: float, first: int = 0, reach: float | np.ndarray = np.inf
) -> SdfSample:
    """Return the nearest body at points [m], (n, 3), of particles from the first on, at a time in the frame [s].

    reach  maximum distance of the query [m], (n,)
    """
    found = SdfSample.blank(len(points), reach)
    for body in bodies:
        body.probe(points[first:], seconds, SdfSample(*(values[first:] for values in found)))
    return found


@njit(cache=True)
def planes_of(found: SdfSample, places: np.ndarray, thickness: np.ndarray, friction: float) -> Planes:
    """Return the planes of what was found at places [m], (N, 3); pure."""
    offsets = np.ones(len(places))
    for k in range(len(places)):
        if np.isfinite(found.distance[k]):
            # Nothing found: a normal of 0 and a gap of 1 m keep the plane out of every test.
            offsets[k] = found.distance[k] - dot(row(found.normal, k), row(places, k))
    return Planes(found.normal, offsets, found.velocity, thickness, friction)


@inlined
def _gap(planes, k, x, left):
    """Return the gap of particle k at x, so many seconds before the end of the frame [m]."""
    n = row(planes.normals, k)
    return dot(n, x) + planes.offsets[k] + left * dot(n, row(planes.drifts, k))


@inlined
def _least_speed(planes, k, x, left, dt):
    """Return the least speed along its normal that a particle may have in a step that begins at x [m/s]."""
    missing = planes.thickness[k] - _gap(planes, k, x, left)
    return dot(row(planes.normals, k), row(planes.drifts, k)) + min(missing / dt, PUSH_OUT)


@njit(cache=True, error_model="numpy")
def constrain(system, planes, moving, left, dt, residual, change):
    """Hold particles that would come too near to bodies, and move them with the bodies, in place.

    The contact force on a single particle with unchanged links determines friction: a damper with mu times this force
    at the speed at which the single particle would slide.

    left, dt          time from the start of the step to the end of the frame, and duration of the step [s]
    residual, change  as `solve` takes them
    """
    held = np.zeros(len(planes.offsets), np.bool_)
    dampers = np.empty(len(held))
    for k in range(system.deep, len(held)):
        n = row(planes.normals, k)
        if dot(n, n) == 0.0:
            continue
        v, drift = row(moving.velocities, k), row(planes.drifts, k)
        least = _least_speed(planes, k, row(moving.points, k), left, dt)
        ahead = plus(v, product(system.inverses, k, (residual[4 * k], residual[4 * k + 1], residual[4 * k + 2])))
        if dot(n, ahead) < least:
            held[k] = True
            push = planes.friction * (least - dot(n, ahead)) / dot(n, product(system.inverses, k, n))
            sliding = flattened(minus(ahead, drift), n)
            speed = length(sliding)
            if speed > 0.0:
                along = scaled(1.0 / speed, sliding)
                speed -= push * dot(along, product(system.inverses, k, along))
            dampers[k] = coulomb(np.inf, push, max(speed, CREEP))
            for c in range(3):
                change[4 * k + c] = (least - dot(n, v)) * n[c]
    if not held.any():
        return
    take_off(system, change, residual)
    for k in range(system.deep, len(held)):
        if held[k]:
            n = row(planes.normals, k)
            u = flattened(minus(row(moving.velocities, k), row(planes.drifts, k)), n)
            r = flattened((residual[4 * k], residual[4 * k + 1], residual[4 * k + 2]), n)
            for c in range(3):
                residual[4 * k + c] = r[c] - dampers[k] * u[c]
            hold(system, k, n, dampers[k])


@njit(cache=True, error_model="numpy")
def touch(planes: Planes, deep: int, left: float, dt: float, moving: Moving) -> None:
    """Stop what comes too near in a step, with the friction of that, in place; left and dt as for `constrain`."""
    for k in range(deep, len(moving.points)):
        n, v, drift = row(planes.normals, k), row(moving.velocities, k), row(planes.drifts, k)
        missing = _least_speed(planes, k, row(moving.points, k), left, dt) - dot(n, v)
        if missing > 0.0:  # Links may have pulled it nearer than `constrain` foresaw.
            pushed = plus(v, scaled(missing, n))
            # Friction of the push, from the velocity before it.
            u = slide(minus(minus(pushed, drift), scaled(missing, n)), n, missing, planes.friction)
            for c in range(3):
                moving.velocities[k, c] = u[c] + drift[c]


@njit(cache=True)
def stale(planes: Planes, found: SdfSample, places: np.ndarray, points: np.ndarray, first: int) -> np.ndarray:
    """Return the moved particles, from the first on, whose planes are no longer valid for the body.

    Pure; they are sorted, (n,).
    """
    which = np.empty(len(points), np.int64)
    count = 0
    for k in range(first, len(points)):
        kept, near = planes.thickness[k], found.distance[k]
        near = near if np.isfinite(near) else 2.0 * kept
        which[count] = k
        count += near - 2.0 * length(minus(row(points, k), row(places, k))) < kept
    return which[:count]


@njit(cache=True, error_model="numpy")
def push_out(found, which, planes, starts, dt, moving):
    """Move particles out that are nearer than their thickness, and remove their inward velocity, in place.

    found   probe of bodies at the particles `which`, (n,), at the end of the frame
    starts  positions at its start [m], (N, 3); dt  its duration [s]
    """
    for a in range(len(which)):
        k = which[a]
        phi, kept = found.distance[a], planes.thickness[k]
        n, b = row(found.normal, a), row(found.velocity, a)
        if not phi < kept or dot(n, n) < 0.5:
            continue
        began = _gap(planes, k, row(starts, k), dt)
        most = min(kept, max(began + PUSH_OUT * dt, 0.0))  # Moved out no faster than `PUSH_OUT`, from where it began.
        u = minus(row(moving.velocities, k), b)
        u = slide(u, n, max(-dot(u, n), 0.0), planes.friction)
        for c in range(3):
            moving.points[k, c] += max(most - phi, 0.0) * n[c]
            moving.velocities[k, c] = b[c] + u[c]
