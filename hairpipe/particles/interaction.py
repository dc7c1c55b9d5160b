"""Forces between hair: pressure, collision and friction of particles, (16) to (18) of Bando, Chen, Nishita 2003.

They act once per frame of duration dt, in sequence, each on the velocities after the previous one; the steps of the
frame apply the result as a force. Hair denser than at rest has the energy k_a m_i (ln(rho_i / rho_0) + rho_0 / rho_i -
1), of which (16) is the force. By backward Euler

    lambda = k_a m_i / rho_i^2 dt max(rho_i - rho_0 + dt rho_i', 0) / (1 + k_a m_i / rho_i^2 dt^2 G . M^-1 G),

with G the derivative of rho_i by all positions, and impulses -lambda G. Collision reduces the speed v_n of approach
along the normal n of both hairs, and friction the tangential speed v_t, (17) and (18): with d W dt / m = a, m the
reduced mass, backward Euler of the pair gives

    j_c = a / (1 + a) m v_n,   j_f = min(a / (1 + a) m v_t, bound (j_c + j_p)),   d = m_i rate pi h_2^3

We differ from the paper: explicit forces of these rates blow up, or make hair on a body tremble; these impulses are
stable at any rate. Pressure does not attract, since particles of thin hair would clump. rho_0 is the density of the
densest hair at rest, since sparse hair may be compressed to it: with its own density as rho_0, hair released from
above the head would keep its volume. Friction has Coulomb's bound. Rates are independent of the number of particles.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, cross, dot, flattened, length, minus, plus, row, scaled
from hairpipe.particles.neighbours import densities, near_pairs, rows_of
from hairpipe.particles.smoothing_kernel import shape, slope

PARALLEL = 0.1
"""Sine of the angle between hairs below which they are taken as parallel."""
TINY = 1e-300


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
    rows     range of particle k in `by` is rows[k]:rows[k+1], (N+1,) int32
    by       pairs of each particle, (2 P,) int32
    density  at every particle [kg/m^3], (N,)
    """

    ends: np.ndarray
    apart: np.ndarray
    rows: np.ndarray
    by: np.ndarray
    density: np.ndarray


@njit(cache=True)
def find_pairs(masses: np.ndarray, points: np.ndarray, h: float) -> Pairs:
    """Find the pairs of particles of masses [kg], (N,), that are at points [m], (N, 3), within 2 h [m]; pure."""
    ends, apart = near_pairs(points, 2.0 * h)
    rows, by = rows_of(ends, len(points))
    return Pairs(ends, apart, rows, by, densities(masses, ends, apart, h))


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
    """Change the velocities of particles by the impulses between them in dt [s], in place.

    inverse_masses  inverse masses of particles, 0 if prescribed [1/kg], (N,)
    """
    count = len(pairs.ends)
    pressed = np.zeros(count)
    if law.pressure > 0.0:
        most = 0  # Room for the largest neighbourhood, once: no memory is taken for each particle.
        for k in range(len(velocities)):
            most = max(most, pairs.rows[k + 1] - pairs.rows[k])
        others = np.empty(most, np.int64)
        gradients = np.empty((most, 4))
        for k in range(len(velocities)):
            if pairs.density[k] > law.rest[k]:  # Each with the velocities that the last has left: on one thread.
                _press(law, pairs, (inverse_masses, points), dt, k, (others, gradients), velocities, pressed)
    over = 1.0 / law.h
    for k in range(count):
        i, j = np.int64(pairs.ends[k, 0]), np.int64(pairs.ends[k, 1])
        first, second = inverse_masses[i], inverse_masses[j]
        u, way = minus(row(velocities, j), row(velocities, i)), minus(row(points, j), row(points, i))
        n = normal_of(row(directions, i), row(directions, j), way)
        hits = dot(u, n) * dot(way, n) < 0.0  # n may point either way: its sign drops out of the product.
        if first + second > 0.0 and (hits or pressed[k] > 0.0):  # else there is nothing, and no friction of it
            pair = law.mass * 0.25 * shape(pairs.apart[k] * over) * dt * (first + second)
            collision = law.collision * pair if hits else 0.0
            impulse = _lost(u, n, collision, law.friction * pair, 1.0 / (first + second), law.bound, pressed[k])
            for c in range(3):
                velocities[i, c] += first * impulse[c]
                velocities[j, c] -= second * impulse[c]


@inlined
def _press(law, pairs, particles, dt, k, room, velocities, pressed):
    """Apply the pressure of particle k, which is too dense, to its neighbours and add it to pair impulses, in place.

    particles  1 / m and positions of all
    room       work arrays for the neighbours, the gradient of the density by their positions, and its signed length
    """
    (inverse_masses, points), (others, gradients) = particles, room
    rate = 0.0
    weight = 0.0
    total = (0.0, 0.0, 0.0)
    mine = row(velocities, k)
    x = row(points, k)
    begin = np.int64(pairs.rows[k])
    end = np.int64(pairs.rows[k + 1])
    over = 1.0 / law.h
    scale = law.mass / (4.0 * np.pi * law.h**4)
    for at in range(begin, end):
        pair = np.int64(pairs.by[at])
        other = np.int64(pairs.ends[pair, 0]) + np.int64(pairs.ends[pair, 1]) - k
        r = pairs.apart[pair]
        size = scale * slope(r * over)
        g = scaled(size / max(r, TINY), minus(row(points, other), x))
        others[at - begin] = other
        gradients[at - begin, 0], gradients[at - begin, 1], gradients[at - begin, 2] = g
        gradients[at - begin, 3] = size
        rate += dot(g, minus(row(velocities, other), mine))
        weight += dot(g, g) * inverse_masses[other]
        total = plus(total, g)  # The gradient by the own place is minus this sum: impulses sum up to nothing.
    weight += inverse_masses[k] * dot(total, total)
    stiff = law.pressure * law.mass / (pairs.density[k] * pairs.density[k])
    push = stiff * dt * max(pairs.density[k] - law.rest[k] + dt * rate, 0.0) / (1.0 + stiff * dt * dt * weight)
    for at in range(end - begin):
        other = others[at]
        pressed[pairs.by[begin + at]] -= push * gradients[at, 3]
        for c in range(3):
            velocities[other, c] -= inverse_masses[other] * push * gradients[at, c]
    for c in range(3):
        velocities[k, c] += inverse_masses[k] * push * total[c]


@inlined
def normal_of(t: Vector, s: Vector, way: Vector) -> Vector:
    """Return a normal of two hairs, of any length; that of parallel ones is the way from one to the other, across."""
    n = cross(t, s)
    crossed = np.float64(dot(n, n) > PARALLEL * PARALLEL)  # no branch to be guessed
    return plus(scaled(crossed, n), scaled(1.0 - crossed, flattened(way, t)))


@inlined
def _lost(u, n, collision, friction, mass, bound, pressed):
    """Return the impulse [N s] on the first of two particles by collision and friction.

    u  velocity of the second against the first; n  normal, of any length
    collision, friction  a of both; mass  reduced mass of both
    """
    square = dot(n, n)
    along = scaled(dot(u, n) / square if square > 0.0 else 0.0, n)
    across = minus(u, along)
    hit = collision / (1.0 + collision) * mass
    rub = friction / (1.0 + friction) * mass
    most = bound * (hit * length(along) + pressed) / length(across)  # inf or NaN without sliding: not less than rub.
    return plus(scaled(hit, along), scaled(most if most < rub else rub, across))
