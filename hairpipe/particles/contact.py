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

from hairpipe.contact.body_projection import slide
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import Vector, dot, length, minus, plus, row, scaled
from hairpipe.levelset.collider import Collider, SdfSample
from hairpipe.particles.model import Moving

PUSH_OUT = 0.5
"""Speed at which a particle that is too near is moved out [m/s]."""


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
    bodies: Sequence[Collider],
    points: np.ndarray,
    seconds: float,
    first: int = 0,
    reach: float | np.ndarray = np.inf,
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
def gap_of(planes: Planes, k: int, x: Vector, left: float) -> float:
    """Return the gap of particle k at x, so many seconds before the end of the frame [m]."""
    n = row(planes.normals, k)
    return dot(n, x) + planes.offsets[k] + left * dot(n, row(planes.drifts, k))


@inlined
def least_speed(planes: Planes, k: int, x: Vector, left: float, dt: float) -> float:
    """Return the least speed along its normal that a particle may have in a step that begins at x [m/s]."""
    n = row(planes.normals, k)
    missing = planes.thickness[k] - gap_of(planes, k, x, left)
    return dot(n, row(planes.drifts, k)) + min(missing / dt, PUSH_OUT)


@inlined
def rubbed(planes: Planes, k: int, v: Vector, push: float) -> Vector:
    """Return a velocity after the friction of a push along the normal that it has had, both [m/s]."""
    n, drift = row(planes.normals, k), row(planes.drifts, k)
    u = slide(minus(minus(v, drift), scaled(push, n)), n, push, planes.friction)
    return plus(u, drift)


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
def push_out(
    found: SdfSample, which: np.ndarray, planes: Planes, starts: np.ndarray, dt: float, moving: Moving
) -> None:
    """Move particles out that are nearer than their thickness, and remove their inward velocity, in place.

    found   probe of bodies at the particles `which`, (n,), at the end of the frame
    starts  positions at its start [m], (N, 3); dt  its duration [s]
    """
    for a in range(len(which)):
        k = which[a]
        phi = found.distance[a]
        kept = planes.thickness[k]
        n = row(found.normal, a)
        b = row(found.velocity, a)
        if not phi < kept or dot(n, n) < 0.5:
            continue
        began = gap_of(planes, k, row(starts, k), dt)
        most = min(kept, max(began + PUSH_OUT * dt, 0.0))  # Moved out no faster than `PUSH_OUT`, from where it began.
        u = minus(row(moving.velocities, k), b)
        inwards = max(-dot(u, n), 0.0)
        u = slide(u, n, inwards, planes.friction)
        for c in range(3):
            moving.points[k, c] += max(most - phi, 0.0) * n[c]
            moving.velocities[k, c] = b[c] + u[c]
