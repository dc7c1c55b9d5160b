"""Pressure (16) and friction (18) as printed by Bando, Chen, Nishita 2003: explicit forces.

    (16)  f_i = - sum_j m_i m_j (P_i / rho_i^2 + P_j / rho_j^2) grad_i W(r_ij, h_2),   P = k_a (rho - rho_0)
    (18)  f_i = sum_j d_f W(r_ij, h_2) v_t,   v_t the part of v_j - v_i across the normal of both hairs

with one rho_0 for all, the mean at rest. Hair of lower density attracts: at the surface particles clump. Friction
grows with speed without bound, whether hair is pressed together or not; if d_f W dt exceeds the reduced mass, it
reverses sliding, and hair explodes.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.kernels.vec3 import flattened, minus, row, unit
from hairpipe.particles.interaction import Pairs, normal_of
from hairpipe.particles.smoothing_kernel import shape, slope


class PrintedLaw(NamedTuple):
    """The laws of interaction used as printed.

    pressure  k_a [m^2/s^2], and
    friction  rate of coincident particles [1/s]; 0 if a law is not used as printed
    rest      density rho_0 [kg/m^3]
    h         smoothing length h_2 [m]
    mass      of a particle [kg]
    """

    pressure: float
    friction: float
    rest: float
    h: float
    mass: float


@njit(cache=True, error_model="numpy")
def push_pairs(
    law: PrintedLaw,
    pairs: Pairs,
    inverse_masses: np.ndarray,
    points: np.ndarray,
    directions: np.ndarray,
    dt: float,
    velocities: np.ndarray,
) -> None:
    """Change the velocities of particles by the forces of all pairs over dt [s], in place.

    inverse_masses  inverse masses of particles, 0 if prescribed [1/kg], (N,)
    """
    forces = np.zeros(velocities.shape)
    for k in range(len(pairs.ends)):
        i, j = pairs.ends[k, 0], pairs.ends[k, 1]
        r = pairs.apart[k]
        way = minus(row(points, j), row(points, i))
        u = minus(row(velocities, j), row(velocities, i))
        pressed = law.pressure * ((pairs.density[i] - law.rest) / pairs.density[i] ** 2)
        pressed += law.pressure * ((pairs.density[j] - law.rest) / pairs.density[j] ** 2)
        steep = law.mass * law.mass * slope(r / law.h) / (4.0 * np.pi * law.h**4)
        normal = normal_of(row(directions, i), row(directions, j), way)
        sliding = flattened(u, unit(normal, normal))
        damper = law.friction * 0.25 * law.mass * shape(r / law.h)
        for c in range(3):
            force = (pressed * steep / r * way[c] if r > 0.0 else 0.0) + damper * sliding[c]
            forces[i, c] += force
            forces[j, c] -= force
    for k in range(len(forces)):
        for c in range(3):
            velocities[k, c] += dt * inverse_masses[k] * forces[k, c]
