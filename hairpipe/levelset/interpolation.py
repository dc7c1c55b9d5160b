"""The level set of a moving body at a time between two frames, by one of three schemes.

A scheme defines where to read each frame, the departure points of semi-Lagrangian advection, and the weights (Sec. 5.1
and Fig. 15 of Selle, Lentine, Fedkiw 2008):

    phi(x, a) = (1 - weight) phi0(x0) + weight phi1(x1),   0 <= a <= 1
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from hairpipe.geometry.compile import inlined
from hairpipe.levelset.sample import FAR_OUTSIDE, Field, brick_at, distance, gradient, velocity


class Interpolation(IntEnum):
    """The schemes, by the name that a setting gives: `Interpolation["two_sided"]`."""

    two_sided = 0
    linear = 1
    one_sided = 2


LINEAR = int(Interpolation.linear)
ONE_SIDED = int(Interpolation.one_sided)
TINY = 1e-300


class DeparturePoints(NamedTuple):
    """Departure points in the two frames [m], and the weight of the second frame, 0 to 1."""

    weight: float
    x0: float
    y0: float
    z0: float
    x1: float
    y1: float
    z1: float


@inlined
def linear(a: float, x: float, y: float, z: float) -> DeparturePoints:
    """Read both frames at the point itself: phi(x, a) = (1 - a) phi0(x) + a phi1(x).

    A body that moves by more than its own radius fades out at its old position and in at the new one.
    """
    return DeparturePoints(a, x, y, z, x, y, z)


@inlined
def one_sided(field0: Field, a: float, dt: float, x: float, y: float, z: float) -> DeparturePoints:
    """Advect the first frame by its own velocity: phi(x, a) = phi0(x - dt a v0(x)).

    The second frame is not read (Kim and Ko, after Selle et al. 2008), so that the body is discontinuous at the start
    of the next pair of frames.
    """
    vx, vy, vz = velocity(field0, x, y, z)
    s = dt * a
    return DeparturePoints(0.0, x - s * vx, y - s * vy, z - s * vz, x, y, z)


@inlined
def two_sided(field0: Field, field1: Field, a: float, dt: float, x: float, y: float, z: float) -> DeparturePoints:
    """Advect both frames to the time between them by their mean velocity, and blend them.

    phi(x, a) = (1 - a) phi0(x - dt a v) + a phi1(x + dt (1 - a) v),  v = (v0(x) + v1(x)) / 2   (Selle et al. 2008, 5)

    We differ from the paper: if only one frame has a velocity at x, it is used for both, instead of its half. An
    ellipsoid that moves by its radius in a frame then has an error of 0.26 % of it instead of 4.1 %.
    """
    ux, uy, uz = velocity(field0, x, y, z)
    vx, vy, vz = velocity(field1, x, y, z)
    known = (brick_at(field0, x, y, z) != FAR_OUTSIDE) + (brick_at(field1, x, y, z) != FAR_OUTSIDE)
    share = 1.0 / max(known, 1)  # A frame without a velocity at x reads 0: the mean is over those that have one.
    mx, my, mz = share * (ux + vx), share * (uy + vy), share * (uz + vz)
    s = dt * a
    r = dt * (1 - a)
    return DeparturePoints(a, x - s * mx, y - s * my, z - s * mz, x + r * mx, y + r * my, z + r * mz)


@inlined
def departure_points(
    scheme: int, field0: Field, field1: Field, a: float, dt: float, x: float, y: float, z: float
) -> DeparturePoints:
    """Return where a scheme reads the two frames; arguments are those of `distance_between`."""
    if scheme == LINEAR:
        found = linear(a, x, y, z)
    elif scheme == ONE_SIDED:
        found = one_sided(field0, a, dt, x, y, z)
    else:
        found = two_sided(field0, field1, a, dt, x, y, z)
    return found


@inlined
def is_far(field0: Field, field1: Field, x: float, y: float, z: float) -> bool:
    """Return whether a point is beyond the bricks of both frames, outside: no scheme can bring the body there."""
    return brick_at(field0, x, y, z) == FAR_OUTSIDE and brick_at(field1, x, y, z) == FAR_OUTSIDE


@inlined
def distance_between(
    scheme: int, field0: Field, field1: Field, a: float, dt: float, x: float, y: float, z: float
) -> float:
    """Return the signed distance [m] to the body, `a` of the interval dt [s] after the first frame, by a scheme."""
    phi = field0.background
    if not is_far(field0, field1, x, y, z):
        phi = distance_at(field0, field1, departure_points(scheme, field0, field1, a, dt, x, y, z))
    return phi


@inlined
def distance_at(field0: Field, field1: Field, at: DeparturePoints) -> float:
    """Return the blended distance [m]."""
    before, after = distance(field0, at.x0, at.y0, at.z0), distance(field1, at.x1, at.y1, at.z1)
    return (1 - at.weight) * before + at.weight * after


@inlined
def normal_at(field0: Field, field1: Field, at: DeparturePoints) -> tuple[float, float, float]:
    """Return the unit outward normal of the blended gradients; 0 where both are 0.

    It ignores the spatial variation of the velocity: with it the result would be the gradient of phi(x, a) itself, but
    for a rotating body this is farther from the body's normal (at 30 degrees per frame 1.3 degrees on average instead
    of 0.8) and more expensive.
    """
    px, py, pz = gradient(field0, at.x0, at.y0, at.z0)
    qx, qy, qz = gradient(field1, at.x1, at.y1, at.z1)
    w0 = 1 - at.weight
    w1 = at.weight
    return normal_of(w0 * px + w1 * qx, w0 * py + w1 * qy, w0 * pz + w1 * qz)


@inlined
def normal_of(nx: float, ny: float, nz: float) -> tuple[float, float, float]:
    """Return the unit vector along a gradient; 0 where that is."""
    scale = 1 / max(np.sqrt(nx * nx + ny * ny + nz * nz), TINY)
    return nx * scale, ny * scale, nz * scale


@inlined
def velocity_at(field0: Field, field1: Field, at: DeparturePoints) -> tuple[float, float, float]:
    """Return the blended velocity [m/s]; where one frame has none, that of the other."""
    w0 = 1 - at.weight
    w1 = at.weight
    if brick_at(field0, at.x0, at.y0, at.z0) == FAR_OUTSIDE:
        w0, w1 = 0.0, 1.0
    elif brick_at(field1, at.x1, at.y1, at.z1) == FAR_OUTSIDE:
        w0, w1 = 1.0, 0.0
    ux, uy, uz = velocity(field0, at.x0, at.y0, at.z0)
    vx, vy, vz = velocity(field1, at.x1, at.y1, at.z1)
    return w0 * ux + w1 * vx, w0 * uy + w1 * vy, w0 * uz + w1 * vz
