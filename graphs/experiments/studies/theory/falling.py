"""A fibre that falls freely in still air without rotating: a closed form of the force, integrated from rest.

Per length, with Re = rho d u / mu of the air, a speed u [m/s], a diameter d and the line density m of the fibre:

    across  f = (1/2) rho d u^2 C_D,  C_D = 1.18 + 6.8 Re^-0.89 + 1.96 Re^-0.5   (Sucker and Brauer 1975)
    along   f = (1/4) mu u 6.8 Re^0.11                                          (half of that friction: Cox 1970)
    rate    f = m k u,  k the damping rate of the air of a scene                (closed form u = g / k (1 - e^(-k t)))

and m u' = m g - f(u), whose limit is the terminal speed f(u) = m g.
"""

from typing import Literal, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from hairpipe.strands.material import Material
from hairpipe.values import Ends

Law = Literal["across", "along", "rate"]
GRAVITY, DENSITY, VISCOSITY = 9.81, 1.2, 1.8e-5
"""Of the Earth [m/s^2] and of its air [kg/m^3, Pa s]."""


class Fall(NamedTuple):
    """Distance [m] and speed [m/s] of a fall."""

    distance: float
    speed: float


def force(law: Law, speed: float, material: Material, rate: float) -> float:
    """Return the force of air on a metre of fibre at a speed [m/s] through it [N/m]; rate of the last law [1/s]."""
    if law == "rate":
        return material.line_density * rate * speed
    reynolds = DENSITY * material.diameter * speed / VISCOSITY
    if law == "along":
        return 0.25 * VISCOSITY * speed * 6.8 * reynolds**0.11
    # C_D Re^-1 with the factor Re^-1 taken in, which is finite at rest.
    drag = 1.18 * reynolds + 6.8 * reynolds**0.11 + 1.96 * reynolds**0.5
    return 0.5 * VISCOSITY * speed * drag


def fallen(law: Law, seconds: float, material: Material, rate: float) -> Fall:
    """Return the fall after a time since its start from rest [s], to 1e-10 of the distance."""
    if seconds <= 0.0:
        return Fall(0.0, 0.0)

    def change(_: float, state: tuple[float, float]) -> tuple[float, float]:
        return state[1], GRAVITY - force(law, max(state[1], 0.0), material, rate) / material.line_density

    found = solve_ivp(change, (0.0, seconds), (0.0, 0.0), rtol=1e-10, atol=1e-13)
    return Fall(*(float(value) for value in found.y[:, -1]))


def dropped_ends(strands: int, law: Law, seconds: float, material: Material, rate: float) -> Ends:
    """Return the ends of strands that fall along -Y, their tips free; arguments as of `fallen`."""
    fall = fallen(law, seconds, material, rate)
    roots = np.tile(np.eye(3, 4), (strands, 1, 1))
    rates = np.zeros_like(roots)
    free = np.full_like(roots, np.nan)
    roots[:, 1, 3] = -fall.distance
    rates[:, 1, 3] = -fall.speed
    return Ends(roots, rates, free, free)
