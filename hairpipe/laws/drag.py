"""Drag of a fibre in air, per length: coefficients c [N s/m^2] such that the force on a metre is -c u.

Across the fibre, with Re = rho d u_n / mu of the speed across alone (independence principle),

    c_n = (1/2) rho d u_n C_D = (1/2) mu Re C_D,   C_D = 1.18 + 6.8 Re^-0.89 + 1.96 Re^-0.5

after Sucker and Brauer, Fluiddynamik bei quer angestroemten Zylindern, 1975, for Re from 1e-4 to 2e5; their last term,
under 0.5 % where Re < 10, is omitted. Hair of 80 um in 1 m/s has Re = 5. Along the fibre

    c_t = (1/2) (1/2) mu 6.8 Re^0.11,   Re = rho d |u| / mu,

half of what friction does across: the ratio of a slender body in creeping flow (Cox, The motion of long slender bodies
in a viscous fluid, 1970). At Re = 50 this is the skin friction that Matsui measured on yarn (1976), 0.37 Re^-0.61, and
at Re = 5 twice that.

The force on a segment of length L and direction d that moves with u relative to the air is

    f = -L (c_n u_n + c_t u_t),   u_t = (u . d) d,   u_n = u - u_t,

half of it at each end, where u is the velocity of that end relative to the air. The coefficients are those of the mean
of both ends at the start of the solve; with them the force is linear in v, and stable for any step.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.geometry.compile import inlined
from hairpipe.laws.settings import Wind


class Law(NamedTuple):
    """Drag of one kind of fibre.

    viscosity   of the air [Pa s]
    per_speed   Reynolds number at 1 m/s [s/m]
    normal      prescribed coefficient across the fibre [N s/m^2], NaN where it follows from the Reynolds number
    tangential  prescribed along it, likewise
    """

    viscosity: float
    per_speed: float
    normal: float
    tangential: float


def law_of(wind: Wind, diameter: float) -> Law:
    """Return the law of drag for a fibre of a diameter [m] in this air."""
    given = wind.coefficients
    normal, tangential = (given.normal, given.tangential) if given else (np.nan, np.nan)
    return Law(wind.viscosity, wind.density * diameter / wind.viscosity, normal, tangential)


@inlined
def normal_drag(law: Law, across: float) -> float:
    """Return c_n [N s/m^2] at a speed across the fibre [m/s]."""
    if law.normal >= 0.0:
        return law.normal
    re = law.per_speed * across
    return 0.5 * law.viscosity * (1.18 * re + 6.8 * re**0.11 + 1.96 * np.sqrt(re))


@inlined
def tangential_drag(law: Law, speed: float) -> float:
    """Return c_t [N s/m^2] at a speed of the air of any direction [m/s]."""
    if law.tangential >= 0.0:
        return law.tangential
    return 0.25 * law.viscosity * 6.8 * (law.per_speed * speed) ** 0.11


@inlined
def add_drag_of_segment(points, velocities, air, k, law, size, push, damping):
    """Add the drag push - damping v of the segment from point k to the next, in place, see `add_drag`."""
    dx, dy, dz = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1], points[k + 1, 2] - points[k, 2]
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    if not length > 0.0:
        return
    dx, dy, dz = dx / length, dy / length, dz / length
    ux = 0.5 * (velocities[k, 0] + velocities[k + 1, 0] - air[k, 0] - air[k + 1, 0])
    uy = 0.5 * (velocities[k, 1] + velocities[k + 1, 1] - air[k, 1] - air[k + 1, 1])
    uz = 0.5 * (velocities[k, 2] + velocities[k + 1, 2] - air[k, 2] - air[k + 1, 2])
    along, squared = ux * dx + uy * dy + uz * dz, ux * ux + uy * uy + uz * uz
    across = np.sqrt(max(squared - along * along, 0.0))  # Rounding may make it negative where wind is along the hair.
    normal = 0.5 * length * normal_drag(law, size * across)
    # c_n (I - d d^T) + c_t d d^T = c_n I + (c_t - c_n) d d^T: half of it for each end.
    excess = 0.5 * length * tangential_drag(law, size * np.sqrt(squared)) - normal
    xx = normal + excess * dx * dx
    xy = excess * dx * dy
    xz = excess * dx * dz
    yy = normal + excess * dy * dy
    yz = excess * dy * dz
    zz = normal + excess * dz * dz
    for p in (k, k + 1):
        wx, wy, wz = air[p, 0], air[p, 1], air[p, 2]
        push[p, 0] += xx * wx + xy * wy + xz * wz
        push[p, 1] += xy * wx + yy * wy + yz * wz
        push[p, 2] += xz * wx + yz * wy + zz * wz
        damping[p, 0] += xx
        damping[p, 1] += xy
        damping[p, 2] += xz
        damping[p, 3] += yy
        damping[p, 4] += yz
        damping[p, 5] += zz
