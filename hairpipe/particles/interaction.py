"""Hair that acts on hair: pressure, collision and friction of particles, (16) to (18) of Bando, Chen, Nishita 2003.

Once a frame of duration dt, one after another, each with the velocities that the last has left; the steps of the frame
then have it as a force. What is denser than at rest has the energy k_a m_i (rho_i - rho_0)^2 / (2 rho_i^2), of which
(16) is the force. By backward Euler

    lambda = k_a m_i / rho_i^2 dt max(rho_i - rho_0 + dt rho_i', 0) / (1 + k_a m_i / rho_i^2 dt^2 G . M^-1 G),

with G the derivative of rho_i by all places, and impulses -lambda G. Collision takes speed v_n along the normal n of
both hairs, where they approach, and friction that across it, v_t, (17) and (18): with d W dt / m = a, m the reduced
mass, backward Euler of the pair gives

    j_c = a / (1 + a) m v_n,   j_f = min(a / (1 + a) m v_t, bound (j_c + j_p)),   d = m_i rate pi h_2^3

We differ from the paper: explicit forces of these rates blow up, or make hair tremble that lies on a body; these
impulses never do, at any rate. Pressure does not attract, as where hair is thin particles would clump. rho_0 is that of
the densest hair at rest, for what stands apart there may lie as close as that: with its own as rho_0, hair let go of
from above the head would keep its room. Friction has Coulomb's bound. Rates do not depend on how many particles stand
for the hair.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, cross, dot, flattened, length, minus, plus, row, scaled, unit
from hairpipe.particles.smoothing_kernel import shape, slope

PARALLEL = 0.1
"""Sine of the angle between hairs below which they are taken as parallel."""


class Law(NamedTuple):
    """Laws of interaction.

    pressure, collision, friction, bound  as in `Interaction`
    h     smoothing length h_2 [m]
    mass  of a particle [kg]
    rest  density of every particle beyond which it presses [kg/m^3], (N,)
    """

    pressure: float
    collision: float
    friction: float
    bound: float
    h: float
    mass: float
    rest: np.ndarray


class Pairs(NamedTuple):
    """Particles near each other.

    ends     (P, 2) int32
    apart    distance [m], (P,)
    rows     of particle k are rows[k]:rows[k+1] in the next, (N+1,) int32
    by       the pairs that each is in, (2 P,) int32
    density  at every particle [kg/m^3], (N,)
    """

    ends: np.ndarray
    apart: np.ndarray
    rows: np.ndarray
    by: np.ndarray
    density: np.ndarray


@njit(cache=True, error_model="numpy")
def exchange(
    law: Law,
    pairs: Pairs,
    inverse_masses: np.ndarray,
    points: np.ndarray,
    directions: np.ndarray,
    dt: float,
    velocities: np.ndarray,
) -> None:
    """Change the velocities of particles by what they exchange in dt [s], in place.

    inverse_masses  of particles, 0 where they are led [1/kg], (N,)
    """
    pressed, count = np.zeros(len(pairs.ends)), len(pairs.ends)
    if law.pressure > 0.0:
        gradients = np.empty((count, 4))
        for k in range(count):
            r = pairs.apart[k]
            g = law.mass * slope(r / law.h) / (4.0 * np.pi * law.h**4)
            away = minus(row(points, pairs.ends[k, 1]), row(points, pairs.ends[k, 0]))
            gradients[k, 0], gradients[k, 1], gradients[k, 2] = scaled(g / r if r > 0.0 else 0.0, away)
            gradients[k, 3] = g
        for k in range(len(velocities)):
            if pairs.density[k] > law.rest[k]:
                _press(law, pairs, inverse_masses, gradients, dt, k, velocities, pressed)
    for k in range(count):
        i, j = pairs.ends[k, 0], pairs.ends[k, 1]
        first, second = inverse_masses[i], inverse_masses[j]
        u, way = minus(row(velocities, j), row(velocities, i)), minus(row(points, j), row(points, i))
        n = normal_of(row(directions, i), row(directions, j), way)
        hits = dot(u, n) * dot(way, n) < 0.0
        if first + second > 0.0 and (hits or pressed[k] > 0.0):  # else there is nothing, and no friction of it
            pair = law.mass * 0.25 * shape(pairs.apart[k] / law.h) * dt * (first + second)
            n = unit(n, n)
            collision = law.collision * pair if hits else 0.0
            impulse = _lost(u, n, collision, law.friction * pair, 1.0 / (first + second), law.bound, pressed[k])
            for c in range(3):
                velocities[i, c] += first * impulse[c]
                velocities[j, c] -= second * impulse[c]


@inlined
def _press(law, pairs, inverse_masses, gradients, dt, k, velocities, pressed):
    """Let particle k, which is too dense, press on those around it, in place; add the impulse to those of its pairs.

    gradients  of the density by the place of the second of a pair, and their length with its sign [kg/m^4], (P, 4)
    """
    rate, weight, total, mine = 0.0, 0.0, (0.0, 0.0, 0.0), row(velocities, k)
    for at in range(pairs.rows[k], pairs.rows[k + 1]):
        pair = pairs.by[at]
        i, j = pairs.ends[pair, 0], pairs.ends[pair, 1]
        other, sign = i + j - k, np.float64((i == k) - (j == k))  # no branch to be guessed
        g = scaled(sign, row(gradients, pair))
        rate += dot(g, minus(row(velocities, other), mine))
        weight += dot(g, g) * inverse_masses[other]
        total = plus(total, g)
    weight += inverse_masses[k] * dot(total, total)
    stiff = law.pressure * law.mass / (pairs.density[k] * pairs.density[k])
    push = stiff * dt * max(pairs.density[k] - law.rest[k] + dt * rate, 0.0) / (1.0 + stiff * dt * dt * weight)
    for at in range(pairs.rows[k], pairs.rows[k + 1]):
        pair = pairs.by[at]
        i, j = pairs.ends[pair, 0], pairs.ends[pair, 1]
        other, sign = i + j - k, np.float64((i == k) - (j == k))
        pressed[pair] -= push * gradients[pair, 3]
        for c in range(3):
            velocities[other, c] -= sign * inverse_masses[other] * push * gradients[pair, c]
    for c in range(3):
        velocities[k, c] += inverse_masses[k] * push * total[c]


@inlined
def normal_of(t: Vector, s: Vector, way: Vector) -> Vector:
    """Return a normal of two hairs, of any length; that of parallel ones is the way from one to the other, across."""
    n = cross(t, s)
    return n if dot(n, n) > PARALLEL * PARALLEL else flattened(way, t)


@inlined
def _lost(u, n, collision, friction, mass, bound, pressed):
    """Return the impulse [N s] on the first of two particles by collision and friction.

    u  velocity of the second against the first; collision, friction  a of both; mass  reduced mass of both
    """
    along = dot(u, n)
    hit = collision / (1.0 + collision) * mass * along
    across = flattened(u, n)
    speed = length(across)
    rub, most = friction / (1.0 + friction) * mass, bound * (abs(hit) + pressed)
    if rub * speed > most:
        rub = most / speed
    return hit * n[0] + rub * across[0], hit * n[1] + rub * across[1], hit * n[2] + rub * across[2]
