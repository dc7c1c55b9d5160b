"""Forces between hair: pressure, collision and friction of particles, (16) to (18) of Bando, Chen, Nishita 2003.

They act once per frame of duration dt, in sequence, each on the velocities after the previous one; the steps of the
frame apply the result as a force. Hair denser than at rest has the energy k_a m_i (ln(rho_i / rho_0) + rho_0 / rho_i -
1), of which (16) is the force; rho_i = sum_j m_j W(r_ij, h_2), (1). By backward Euler

    lambda = k_a m_i / rho_i^2 dt max(rho_i - rho_0 + dt rho_i', 0) / (1 + k_a m_i / rho_i^2 dt^2 G . M^-1 G),

with G the derivative of rho_i by all positions, and impulses -lambda G. Collision reduces the speed v_n of approach
along the normal n of both hairs, and friction the tangential speed v_t, (17) and (18): with d W dt / m = a, m the
reduced mass, backward Euler of the pair gives

    j_c = a / (1 + a) m v_n,   j_f = min(a / (1 + a) m v_t, bound (j_c + j_p)),   d = m_i rate pi h_2^3

We differ from the paper: explicit forces of these rates blow up, or make hair on a body tremble; these impulses are
stable at any rate. Pressure does not attract, since particles of thin hair would clump. rho_0 is the density of the
densest hair at rest, since sparse hair may be compressed to it: with its own density as rho_0, hair released from
above the head would keep its volume. Friction has Coulomb's bound. Rates are independent of the number of particles.

Pressure (16) and friction (18) as printed are explicit forces,

    (16)  f_i = - sum_j m_i m_j (P_i / rho_i^2 + P_j / rho_j^2) grad_i W(r_ij, h_2),   P = k_a (rho - rho_0)
    (18)  f_i = sum_j d_f W(r_ij, h_2) v_t,   v_t the part of v_j - v_i across the normal of both hairs

with one rho_0 for all, the mean at rest. Hair of lower density attracts: at the surface particles clump. Friction
grows with speed without bound, whether hair is pressed together or not; if d_f W dt exceeds the reduced mass, it
reverses sliding, and hair explodes.

Pairs are found in cells of 2 h_2, in whose order they are, independent of threads. For sparse hair with many more
cells than particles, cells are larger. A few outliers do not enlarge them.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import Vector, cross, dot, flattened, length, minus, plus, row, scaled, unit
from hairpipe.laws.coulomb import coulomb
from hairpipe.particles.model import shape, slope

CELLS = 4
"""Cells a particle, at most."""
WIDE = 3.0
"""Standard deviations from the mean to which there are cells; what is farther lies in the outermost."""
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
    rows     range of particle k in `by` is rows[k]:rows[k+1], (N+1,) int64
    by       pairs of each particle, (2 P,) int32
    density  at every particle [kg/m^3], (N,)
    """

    ends: np.ndarray
    apart: np.ndarray
    rows: np.ndarray
    by: np.ndarray
    density: np.ndarray


@njit(cache=True, error_model="numpy")
def find_pairs(masses: np.ndarray, points: np.ndarray, h: float) -> Pairs:
    """Find the pairs of particles of masses [kg], (N,), that are at points [m], (N, 3), within 2 h [m]; pure."""
    ends, apart = _near(points, 2.0 * h)
    rows, order = _sorted_by_count(ends.ravel(), len(points))
    scale = 1.0 / (4.0 * np.pi * h * h * h)
    density = 4.0 * scale * masses  # A particle's own share, W(0).
    for k in range(len(ends)):
        i, j = ends[k, 0], ends[k, 1]
        weight = scale * shape(apart[k] / h)
        density[i] += masses[j] * weight
        density[j] += masses[i] * weight
    return Pairs(ends, apart, rows, order // np.int32(2), density)


@njit(cache=True, error_model="numpy")
def _near(points, distance):
    """Return all pairs nearer than a distance [m], (P, 2) int32, and how far apart they are [m], (P,)."""
    cells, (nx, ny, nz) = _cells_of(points, distance)
    first, order = _sorted_by_count(cells, nx * ny * nz)
    placed = points[order]
    most = distance * distance
    pairs = np.empty((16 * len(points) + 64, 2), np.int32)
    apart = np.empty(16 * len(points) + 64)
    begins, ends = np.zeros(5, np.int64), np.zeros(5, np.int64)
    found = 0
    for cell in range(nx * ny * nz):
        if first[cell] == first[cell + 1]:
            continue
        x = cell // (ny * nz)
        y = cell // nz % ny
        z = cell % nz
        # Half of the cells about this one, so that each pair is found once. z goes fastest: cells in a row are one
        # range of particles, five ranges in place of fourteen cells.
        ends[0] = first[min(cell + 1, (x * ny + y) * nz + nz - 1) + 1]
        for r in range(1, 5):
            a, b = (x, y + 1) if r == 1 else (x + 1, y + r - 3)
            line = (a * ny + b) * nz
            there = a < nx and 0 <= b < ny
            begins[r] = first[line + max(z - 1, 0)] if there else 0
            ends[r] = first[line + min(z + 1, nz - 1) + 1] if there else 0
        for k in range(first[cell], first[cell + 1]):
            begins[0] = k + 1
            room = found + (ends - begins).sum()
            if room > len(apart):
                pairs = np.concatenate((pairs, np.empty((room, 2), np.int32)))
                apart = np.concatenate((apart, np.empty(room)))
            px, py, pz = row(placed, k)
            for r in range(5):
                for other in range(begins[r], ends[r]):
                    u, v, w = placed[other, 0] - px, placed[other, 1] - py, placed[other, 2] - pz
                    square = u * u + v * v + w * w
                    pairs[found, 0] = order[k]
                    pairs[found, 1] = order[other]
                    apart[found] = square
                    found += square < most  # Written always, and kept if near: a branch would be guessed wrong.
    return pairs[:found], np.sqrt(apart[:found])


@njit(cache=True, error_model="numpy")
def _cells_of(points, size):
    """Return the cells of particles, (N,), and the numbers of cells along the axes."""
    low, high = np.empty(3), np.empty(3)
    for c in range(3):
        first = points[0, c]
        least = np.inf
        greatest = -np.inf
        total = 0.0
        squares = 0.0
        for k in range(len(points)):
            x = points[k, c] - first  # From the first point on: far from the origin squares lose digits.
            least = min(least, x)
            greatest = max(greatest, x)
            total += x
            squares += x * x
        mean = total / len(points)
        wide = WIDE * np.sqrt(max(squares / len(points) - mean * mean, 0.0))
        low[c] = max(least + first, mean + first - wide)
        high[c] = min(greatest + first, mean + first + wide)
    x, y, z = high[0] - low[0], high[1] - low[1], high[2] - low[2]
    while (x // size + 1.0) * (y // size + 1.0) * (z // size + 1.0) > CELLS * len(points) + 64:
        size *= 2.0  # Empty cells cost time and memory, too: no more than a few for each particle.
    nx, ny, nz = np.int64(x // size + 1.0), np.int64(y // size + 1.0), np.int64(z // size + 1.0)
    cells = np.empty(len(points), np.int64)
    over = 1.0 / size
    for k in range(len(points)):
        a = min(max(np.int64((points[k, 0] - low[0]) * over), 0), nx - 1)
        b = min(max(np.int64((points[k, 1] - low[1]) * over), 0), ny - 1)
        c = min(max(np.int64((points[k, 2] - low[2]) * over), 0), nz - 1)
        cells[k] = (a * ny + b) * nz + c
    return cells, (nx, ny, nz)


@njit(cache=True)
def _sorted_by_count(keys, count):
    """Return where each of so many keys begins in their order, (count + 1,), and the order; equal ones keep theirs."""
    first = np.zeros(count + 1, np.int64)
    for key in keys:
        first[key + 1] += 1
    for key in range(count):
        first[key + 1] += first[key]
    after = first.copy()
    order = np.empty(len(keys), np.int32)
    for k in range(len(keys)):
        order[after[keys[k]]] = k
        after[keys[k]] += 1
    return first, order


@njit(cache=True, error_model="numpy")
def exchange(law, pairs, inverse_masses, points, directions, dt, velocities):
    """Change the velocities of particles by the impulses between them in dt [s], in place.

    inverse_masses  inverse masses of particles, 0 if prescribed [1/kg], (N,)
    """
    count = len(pairs.ends)
    pressed = np.zeros(count)
    if law.pressure > 0.0:
        most = (pairs.rows[1:] - pairs.rows[:-1]).max()  # No memory is taken for each particle.
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

    room  work arrays: neighbours, and the gradient of the density by their positions, its signed length last
    """
    (inverse_masses, points), (others, gradients) = particles, room
    rate, weight = 0.0, 0.0
    total = (0.0, 0.0, 0.0)
    begin = np.int64(pairs.rows[k])
    end = np.int64(pairs.rows[k + 1])
    over = 1.0 / law.h
    scale = law.mass / (4.0 * np.pi * law.h**4)
    for at in range(begin, end):
        pair = np.int64(pairs.by[at])
        other = np.int64(pairs.ends[pair, 0]) + np.int64(pairs.ends[pair, 1]) - k
        r = pairs.apart[pair]
        size = scale * slope(r * over)
        g = scaled(size / max(r, TINY), minus(row(points, other), row(points, k)))
        others[at - begin] = other
        for c in range(3):
            gradients[at - begin, c] = g[c]
        gradients[at - begin, 3] = size
        rate += dot(g, minus(row(velocities, other), row(velocities, k)))
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
    """Return the impulse [N s] on the first of two particles, of reduced mass [kg], by a of collision and friction.

    u  velocity of the second against the first; n  normal, of any length
    """
    square = dot(n, n)
    along = scaled(dot(u, n) / square if square > 0.0 else 0.0, n)
    across = minus(u, along)
    hit = collision / (1.0 + collision) * mass
    rub = friction / (1.0 + friction) * mass
    slowed = coulomb(rub, bound * (hit * length(along) + pressed), length(across))
    return plus(scaled(hit, along), scaled(slowed, across))


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
