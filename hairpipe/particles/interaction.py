"""Hair that acts on hair: pressure, collision and friction of particles, (16) to (18) of Bando, Chen, Nishita 2003.

Once a frame of duration dt, pair by pair, each with the velocities that the last has left. Pressure gives the impulse

    j_p = m_i m_j (p_i + p_j) |dW/dr| dt,   p = k_a max(rho - rho_0, 0) / rho^2              (16)

away from each other. Collision takes speed v_n along the normal n of both hairs, where they approach, and friction that
across it, v_t, (17) and (18): with d W dt / mu = a, 1/mu = 1/m_i + 1/m_j, backward Euler of the pair gives

    j_c = a / (1 + a) mu v_n,   j_f = min(a / (1 + a) mu v_t, bound (j_c + j_p)),   d = m rate pi h_2^3

We differ from the paper: explicit forces of these rates blow up; these impulses never add energy, at any rate. Pressure
does not attract, and rho_0 is the particle's own at rest: one for all draws in what is at the surface of the hair, where
particles then clump. Friction has Coulomb's bound. Rates do not depend on how many particles stand for the hair.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import cross, dot, flattened, length, minus, row, scaled
from hairpipe.particles.smoothing_kernel import shape, slope

PARALLEL = 0.1
"""Sine of the angle between hairs below which they are taken as parallel."""


class Law(NamedTuple):
    """Laws of interaction.

    pressure, collision, friction, bound  as in `Interaction`
    h     smoothing length h_2 [m]
    rest  density of every particle at rest [kg/m^3], (N,)
    """

    pressure: float
    collision: float
    friction: float
    bound: float
    h: float
    rest: np.ndarray


class Pairs(NamedTuple):
    """Particles near each other, and what they are like.

    ends      (P, 2) int32
    apart     distance [m], (P,)
    density   at every particle [kg/m^3], (N,)
    """

    ends: np.ndarray
    apart: np.ndarray
    density: np.ndarray


@njit(cache=True, error_model="numpy")
def exchange(
    law: Law,
    pairs: Pairs,
    masses: np.ndarray,
    deep: int,
    points: np.ndarray,
    directions: np.ndarray,
    dt: float,
    velocities: np.ndarray,
) -> None:
    """Change the velocities of free particles by what they exchange in dt [s], in place.

    Those below the skin, which come first, act as if they had no end of mass.
    """
    h, mass = law.h, masses[deep:].mean()
    pressures = np.empty(len(masses))
    for k in range(len(masses)):
        over = max(pairs.density[k] - law.rest[k], 0.0)
        pressures[k] = law.pressure * over / (pairs.density[k] * pairs.density[k])
    for k in range(len(pairs.ends)):
        i, j = pairs.ends[k, 0], pairs.ends[k, 1]
        if i < deep and j < deep:
            continue
        way, r = minus(row(points, j), row(points, i)), pairs.apart[k]
        away = scaled(1.0 / r if r > 0.0 else 0.0, way)
        q = r / h
        pressed = masses[i] * masses[j] * (pressures[i] + pressures[j])
        pressed *= -slope(q) / (4.0 * np.pi * h**4) * dt
        first = 0.0 if i < deep else 1.0 / masses[i]
        second = 0.0 if j < deep else 1.0 / masses[j]
        pair = mass * 0.25 * shape(q) * dt * (first + second)
        u = minus(row(velocities, j), row(velocities, i))
        n = _normal(row(directions, i), row(directions, j), way)
        impulse = _lost(
            u, n, way, (law.collision * pair, law.friction * pair), 1.0 / (first + second), law.bound, pressed
        )
        for c in range(3):
            given = impulse[c] - pressed * away[c]
            velocities[i, c] += first * given
            velocities[j, c] -= second * given


@inlined
def _normal(t, s, way):
    """Return the unit normal of two hairs; that of parallel ones is the way from one to the other, across them."""
    n = cross(t, s)
    size = length(n)
    if size < PARALLEL:
        n = flattened(way, t)
        size = length(n)
    return scaled(1.0 / size if size > 0.0 else 0.0, n)


@inlined
def _lost(u, n, way, rates, mass, bound, pressed):
    """Return the impulse [N s] on the first of two particles by collision and friction.

    u      velocity of the second against the first; rates  a of both laws; mass  reduced mass of both
    """
    along = dot(u, n)
    hit = rates[0] / (1.0 + rates[0]) * mass * along if along * dot(way, n) < 0.0 else 0.0
    across = flattened(u, n)
    speed = length(across)
    rub = rates[1] / (1.0 + rates[1]) * mass
    most = bound * (abs(hit) + pressed)
    if rub * speed > most:
        rub = most / speed
    return hit * n[0] + rub * across[0], hit * n[1] + rub * across[1], hit * n[2] + rub * across[2]
