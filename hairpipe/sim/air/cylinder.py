"""Drag of a fibre in air, per length: coefficients c [N s/m^2] such that the force on a metre is -c u.

Across the fibre, with Re = rho d u_n / mu of the speed across alone (independence principle),

    c_n = (1/2) rho d u_n C_D = (1/2) mu Re C_D,   C_D = 1.18 + 6.8 Re^-0.89 + 1.96 Re^-0.5

after Sucker and Brauer, Fluiddynamik bei quer angestroemten Zylindern, 1975, for Re from 1e-4 to 2e5; their last term,
under 0.5 % where Re < 10, is omitted. Hair of 80 um in 1 m/s has Re = 5. Along the fibre

    c_t = (1/2) (1/2) mu 6.8 Re^0.11,   Re = rho d |u| / mu,

half of what friction does across: the ratio of a slender body in creeping flow (Cox, The motion of long slender bodies
in a viscous fluid, 1970). At Re = 50 this is the skin friction that Matsui measured on yarn (1976), 0.37 Re^-0.61, and
at Re = 5 twice that.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.kernels.compile import inlined
from hairpipe.sim.air.wind import Wind


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
