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

Particles near each other now, and the density (1) of Bando, Chen, Nishita 2003: rho_i = sum_j m_j W(r_ij, h_2).

Space is divided into cells of 2 h_2, in which particles are counted and sorted; for sparse hair with many more cells
than particles, cells are larger. A few outliers do not enlarge them. Pairs are in the order of cells, independent of
threads.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import WIDTH, bits, load, lowest, store
from hairpipe.geometry.vec3 import Vector, cross, dot, flattened, length, minus, plus, row, scaled
from hairpipe.particles.model import shape, slope

CELLS = 4
"""Cells a particle, at most."""
WIDE = 3.0
"""Standard deviations from the mean to which there are cells; what is farther lies in the outermost."""


@njit(cache=True, error_model="numpy")
def near_pairs(points: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return all pairs nearer than a distance [m], (P, 2) int32, and how far apart they are [m], (P,); pure."""
    order, first, (nx, ny, nz) = _sorted_into_cells(points, distance)
    room = 16 * len(points) + 64
    found = 0
    most = distance * distance
    pairs = np.empty((room, 2), np.int32)
    apart = np.empty(room)
    around = _make_room(WIDTH)
    for cell in range(len(first) - 1):
        if first[cell] == first[cell + 1]:
            continue
        begins = _ranges(first, cell, (nx, ny, nz))
        count = 0
        for begin, end in begins:
            count += end - begin
        if count > around.order.size:
            around = _make_room(2 * count)
        _gather(points, order, begins, around)
        for a in range(first[cell + 1] - first[cell]):
            if found + count >= len(pairs):
                pairs, apart = _longer(pairs, apart, count)
            found = _add_near(around, a, count, most, pairs, apart, found)
    for k in range(found):
        apart[k] = np.sqrt(apart[k])
    return pairs[:found], apart[:found]


class Around(NamedTuple):
    """Particles of a cell, then those of half of the cells about it, in lanes.

    places   [m], inf in the lanes beyond the last, (3, rows, W) float64
    order    indices of these particles, (rows W,)
    squares  of distances in a row of lanes, (1, W)
    """

    places: np.ndarray
    order: np.ndarray
    squares: np.ndarray


@njit(cache=True)
def _make_room(count):
    rows = (count + WIDTH - 1) // WIDTH
    return Around(np.empty((3, rows, WIDTH)), np.empty(rows * WIDTH, np.int64), np.empty((1, WIDTH)))


@inlined
def _ranges(first, cell, counts):
    """Return where particles begin and end: of a cell and the next; then of rows of three cells on one side."""
    _, ny, nz = counts
    cx = cell // (ny * nz)
    cy = cell // nz % ny
    cz = cell % nz
    # z goes fastest, so that cells in a row are one range of particles: five ranges in place of fourteen cells.
    own = first[cell], first[min(cell + 1, (cx * ny + cy) * nz + nz - 1) + 1]
    return (
        own,
        _row_of(first, (cx, cy + 1, cz), counts),
        _row_of(first, (cx + 1, cy - 1, cz), counts),
        _row_of(first, (cx + 1, cy, cz), counts),
        _row_of(first, (cx + 1, cy + 1, cz), counts),
    )


@inlined
def _row_of(first, cell, counts):
    (x, y, z), (nx, ny, nz) = cell, counts
    if x >= nx or y < 0 or y >= ny:
        return first[0], first[0]
    line = (x * ny + y) * nz
    return first[line + max(z - 1, 0)], first[line + min(z + 1, nz - 1) + 1]


@inlined
def _gather(points, order, begins, around):
    """Write particles to lanes, in place."""
    n = 0
    for begin, end in begins:
        for at in range(begin, end):
            around.order[n] = order[at]
            for c in range(3):
                around.places[c, n // WIDTH, n % WIDTH] = points[order[at], c]
            n += 1
    while n % WIDTH:
        around.places[0, n // WIDTH, n % WIDTH] = np.inf  # Infinitely far: the last lanes find no pair.
        n += 1


@inlined
def _add_near(around, a, count, most, pairs, apart, found):
    """Add the pairs of particle a, in place, with those after it that are nearer than the root of most; count them."""
    x, y, z = (
        around.places[0, a // WIDTH, a % WIDTH],
        around.places[1, a // WIDTH, a % WIDTH],
        around.places[2, a // WIDTH, a % WIDTH],
    )
    begin = a + 1
    for r in range(begin // WIDTH, (count + WIDTH - 1) // WIDTH):
        u, v, w = load(around.places, (0, r)) - x, load(around.places, (1, r)) - y, load(around.places, (2, r)) - z
        squares = u * u + v * v + w * w
        near = bits(squares < most)
        if r == begin // WIDTH:
            near &= -(1 << (begin % WIDTH))  # In its first row only lanes after the particle itself: each pair once.
        if near:
            store(around.squares, (0,), squares)
        while near:
            lane = lowest(near)
            pairs[found, 0], pairs[found, 1] = around.order[a], around.order[r * WIDTH + lane]
            apart[found] = around.squares[0, lane]
            found += 1
            near &= near - 1
    return found


@njit(cache=True)
def _longer(pairs, apart, more):
    """Return both with room for as many again, and more."""
    longer = np.empty((2 * len(pairs) + more, 2), np.int32)
    far = np.empty(2 * len(pairs) + more)
    for k in range(len(pairs)):
        longer[k, 0], longer[k, 1], far[k] = pairs[k, 0], pairs[k, 1], apart[k]
    return longer, far


@njit(cache=True, error_model="numpy")
def _sorted_into_cells(points, size):
    """Return particles cell by cell, where each begins, and how many there are along the axes; z goes fastest."""
    low, high = np.empty(3), np.empty(3)
    for c in range(3):
        low[c], high[c], total, squares = np.inf, -np.inf, 0.0, 0.0
        for k in range(len(points)):
            x = points[k, c] - points[0, c]  # From the first point on: far from the origin squares lose digits.
            low[c], high[c], total, squares = min(low[c], x), max(high[c], x), total + x, squares + x * x
        mean = total / len(points)
        wide = WIDE * np.sqrt(max(squares / len(points) - mean * mean, 0.0))
        low[c], high[c], mean = low[c] + points[0, c], high[c] + points[0, c], mean + points[0, c]
        low[c], high[c] = max(low[c], mean - wide), min(high[c], mean + wide)
    while True:
        nx, ny, nz = (
            (high[0] - low[0]) // size + 1.0,
            (high[1] - low[1]) // size + 1.0,
            (high[2] - low[2]) // size + 1.0,
        )
        if nx * ny * nz <= CELLS * len(points) + 64:
            break
        size *= 2.0  # Empty cells cost time and memory, too: no more than a few for each particle.
    x, y, z = np.int64(nx), np.int64(ny), np.int64(nz)
    cells = np.empty(len(points), np.int64)
    first = np.zeros(x * y * z + 1, np.int64)
    over = 1.0 / size
    for k in range(len(points)):
        a = min(max(np.int64((points[k, 0] - low[0]) * over), 0), x - 1)
        b = min(max(np.int64((points[k, 1] - low[1]) * over), 0), y - 1)
        c = min(max(np.int64((points[k, 2] - low[2]) * over), 0), z - 1)
        cells[k] = (a * y + b) * z + c
        first[cells[k] + 1] += 1
    for cell in range(x * y * z):
        first[cell + 1] += first[cell]
    order = np.empty(len(points), np.int64)
    filled = np.zeros(len(first), np.int64)
    for k in range(len(points)):
        order[first[cells[k]] + filled[cells[k]]] = k
        filled[cells[k]] += 1
    return order, first, (x, y, z)


@njit(cache=True, error_model="numpy")
def densities(masses: np.ndarray, pairs: np.ndarray, apart: np.ndarray, h: float) -> np.ndarray:
    """Return the density at every particle [kg/m^3], (N,); pure.

    masses  [kg], (N,); pairs, apart  as `near_pairs` gives them; h  smoothing length [m]
    """
    scale = 1.0 / (4.0 * np.pi * h * h * h)
    density = np.empty(len(masses))
    for k in range(len(masses)):
        density[k] = 4.0 * scale * masses[k]  # A particle's own share, W(0).
    for k in range(len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        weight = scale * shape(apart[k] / h)
        density[i] += masses[j] * weight
        density[j] += masses[i] * weight
    return density


@njit(cache=True)
def rows_of(pairs: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return where the pairs of every one of so many particles are listed, (count + 1,), and these, int32; pure."""
    rows = np.zeros(count + 1, np.int32)
    for k in range(len(pairs)):
        rows[pairs[k, 0] + 1] += 1
        rows[pairs[k, 1] + 1] += 1
    for k in range(count):
        rows[k + 1] += rows[k]
    by = np.empty(2 * len(pairs), np.int32)
    filled = np.zeros(count, np.int32)
    for k in range(len(pairs)):
        for end in range(2):
            particle = pairs[k, end]
            by[rows[particle] + filled[particle]] = k
            filled[particle] += 1
    return rows, by


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
