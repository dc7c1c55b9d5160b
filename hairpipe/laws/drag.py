"""Drag of a fibre in air, per length: coefficients c [N s/m^2] such that the force on a metre is -c u.

Across the fibre, with Re = rho d u_n / mu of the speed across alone (independence principle),

    c_n = (1/2) rho d u_n C_D = (1/2) mu Re C_D,   C_D = 1.18 + 6.8 Re^-0.89 + 1.96 Re^-0.5

after Sucker and Brauer, Fluiddynamik bei quer angestroemten Zylindern, 1975, for Re from 1e-4 to 2e5; their last term,
under 0.5 % where Re < 10, is omitted. Hair of 80 um in 1 m/s has Re = 5. Along the fibre

    c_t = (1/2) (1/2) mu 6.8 Re^0.11,   Re = rho d |u| / mu,

half of what friction does across: the ratio of a slender body in creeping flow (Cox, The motion of long slender bodies
in a viscous fluid, 1970). At Re = 50 this is the skin friction that Matsui measured on yarn (1976), 0.37 Re^-0.61, and
at Re = 5 twice that.

Settings of the wind of a shot, in physical units.
"""

from dataclasses import dataclass
from math import hypot
from typing import Annotated, NamedTuple
from warnings import warn

import numpy as np

from hairpipe.geometry.compile import inlined
from hairpipe.units import Ge, Gt, Interval, KilogramsPerCubicMetre, Metres, MetresPerSecond, PascalSeconds, Seconds

STORM = 115.0
"""Speed of the strongest gust that was measured near the ground, in 1996, rounded up [m/s]."""
Velocity = tuple[MetresPerSecond, MetresPerSecond, MetresPerSecond]


@dataclass(frozen=True)
class Coefficients:
    """Linear drag: force on a metre of hair at 1 m/s.

    normal      drag coefficient of flow across the hair
    tangential  drag coefficient of flow along the hair
    """

    normal: Annotated[PascalSeconds, Interval(ge=0.0, le=1.0)] = 2e-4
    tangential: Annotated[PascalSeconds, Interval(ge=0.0, le=1.0)] = 5e-5


@dataclass(frozen=True)
class Gusts:
    """Turbulent eddies, advected by the wind.

    strength  root mean square of each component of the velocity
    size      correlation length: the correlation along a line is exp(-(r / size)^2 / 2)
    duration  correlation time in the moving frame: the correlation is exp(-(t / duration)^2 / 2)
    seed      seed of the random numbers
    """

    strength: Annotated[MetresPerSecond, Interval(ge=0.0, le=100.0)] = 1.0
    size: Annotated[Metres, Interval(gt=1e-3, le=1e3)] = 0.5
    duration: Annotated[Seconds, Interval(gt=1e-3, le=1e4)] = 0.5
    seed: Annotated[int, Ge(0)] = 0


@dataclass(frozen=True)
class Shielding:
    """Reduction of the wind by hair upstream.

    cell   cell size of the grid of hair density; larger for a very wide groom
    hairs  number of hairs that a strand represents in the density
    """

    cell: Annotated[Metres, Interval(ge=1e-3, le=1.0)] = 0.01
    hairs: Annotated[float, Interval(ge=0.0, le=1e6)] = 1.0


@dataclass(frozen=True)
class Wind:
    """Moving air and the drag of a fibre in it, in place of `air.drag` for still air.

    velocity      mean velocity of the air; zero for the drag of still air
    density       mass density of the air
    viscosity     dynamic viscosity of the air
    coefficients  prescribed drag coefficients, in place of those of a cylinder at its Reynolds number
    gusts         turbulence of the wind; if absent, the wind is steady
    shielding     reduction of the wind by hair upstream; if absent, the wind is uniform
    """

    velocity: Velocity = (0.0, 0.0, -1.0)
    density: Annotated[KilogramsPerCubicMetre, Gt(0.0)] = 1.2
    viscosity: Annotated[PascalSeconds, Gt(0.0)] = 1.8e-5
    coefficients: Coefficients | None = None
    gusts: Gusts | None = None
    shielding: Shielding | None = None


def warn_of_storm(wind: Wind | None) -> None:
    """Warn of a mean velocity above that of any storm."""
    speed = 0.0 if wind is None else hypot(*wind.velocity)
    if speed > STORM:
        message = f"wind.velocity has {speed:,.0f} m/s, above {STORM:.0f} m/s, the strongest gust ever measured"
        warn(f"{message} (velocities are in m/s)", stacklevel=3)


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
