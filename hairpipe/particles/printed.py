"""Explicit steps, as Bando, Chen, Nishita 2003 take them: symplectic Euler.

    v' = v + dt / m (M g + p - C v + sum f_e),   f_e = d (K (r - l) + c d . u),   x' = x + dt v'

with the terms of the implicit step, `hairpipe/particles/step.py`, except that pairs, stiffness and directions (15) are
updated in every step. Links are stable only for dt < 2 / omega of the fastest oscillation: the number of steps per
frame is proportional to the square root of the modulus, and to the number of particles along a hair.

Pressure (16) and friction (18) as printed by Bando, Chen, Nishita 2003: explicit forces.

    (16)  f_i = - sum_j m_i m_j (P_i / rho_i^2 + P_j / rho_j^2) grad_i W(r_ij, h_2),   P = k_a (rho - rho_0)
    (18)  f_i = sum_j d_f W(r_ij, h_2) v_t,   v_t the part of v_j - v_i across the normal of both hairs

with one rho_0 for all, the mean at rest. Hair of lower density attracts: at the surface particles clump. Friction
grows with speed without bound, whether hair is pressed together or not; if d_f W dt exceeds the reduced mass, it
reverses sliding, and hair explodes.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.geometry.vec3 import dot, flattened, minus, row, unit
from hairpipe.particles.contact import Planes, touch
from hairpipe.particles.interaction import normal_of
from hairpipe.particles.links import measure_links, stiffen
from hairpipe.particles.model import Model, Moving, inverse_masses, shape, slope
from hairpipe.particles.step import Forces, Springs


def advance_explicitly(
    model: Model,
    springs: Springs,
    forces: Forces,
    planes: Planes,
    roots: np.ndarray,
    dt: float,
    moving: Moving,
    begin: Callable[[Moving, float], None],
) -> None:
    """Compute the steps of a frame, in place, while particles are finite; arguments are those of `advance`.

    begin  called before every step with its duration [s]: pairs change velocities, and directions turn
    """
    for step in range(len(roots) - 1):
        if not np.isfinite(moving.points).all():
            return
        begin(moving, dt)
        left = (len(roots) - 1 - step) * dt
        _step(model, springs, forces, planes, roots[step : step + 2], left, dt, moving)


@njit(cache=True, error_model="numpy")
def _step(model, springs, forces, planes, roots, left, dt, moving):
    """Do a step that begins so many seconds before the end of the frame, in place."""
    links = model.links
    deep = model.deep
    count = len(model.masses)
    ways = np.empty((len(links.ends), 4))
    stiffness = np.empty(len(links.ends))
    inverses = inverse_masses(model)
    measure_links(links, moving.points, ways)
    stiffen(links, model.reach, springs.axial, ways, stiffness)
    for k in range(deep):
        for c in range(3):
            moving.velocities[k, c] = (roots[1, k, c] - roots[0, k, c]) / dt
    total = forces.push.copy()
    v = moving.velocities
    C = forces.drag
    for k in range(count):
        total[k, 0] -= C[k, 0] * v[k, 0] + C[k, 1] * v[k, 1] + C[k, 2] * v[k, 2]
        total[k, 1] -= C[k, 1] * v[k, 0] + C[k, 3] * v[k, 1] + C[k, 4] * v[k, 2]
        total[k, 2] -= C[k, 2] * v[k, 0] + C[k, 4] * v[k, 1] + C[k, 5] * v[k, 2]
    for e in range(len(links.ends)):
        i, j = links.ends[e, 0], links.ends[e, 1]
        damper = 2.0 * springs.damping * np.sqrt(stiffness[e] / (inverses[i] + inverses[j]))
        moving.tensions[e] = stiffness[e] * (ways[e, 3] - springs.rest[e])
        force = moving.tensions[e] + damper * dot(row(ways, e), minus(row(v, j), row(v, i)))
        for c in range(3):
            total[i, c] += force * ways[e, c]
            total[j, c] -= force * ways[e, c]
    for k in range(deep, count):
        for c in range(3):
            v[k, c] += dt * inverses[k] * total[k, c]
    touch(planes, deep, left, dt, moving)
    for k in range(count):
        for c in range(3):
            moving.points[k, c] = moving.points[k, c] + dt * v[k, c] if k >= deep else roots[1, k, c]


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
def push_pairs(law, pairs, inverse_masses, points, directions, dt, velocities):
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
