"""Particles near each other now, and the density (1) of Bando, Chen, Nishita 2003: rho_i = sum_j m_j W(r_ij, h_2).

Space is divided into cells of 2 h_2, in which particles are counted and sorted; for sparse hair with many more cells
than particles, cells are larger. A few outliers do not enlarge them. Pairs are in the order of cells, independent of
threads.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import WIDTH, bits, load, lowest, store
from hairpipe.particles.smoothing_kernel import shape

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
