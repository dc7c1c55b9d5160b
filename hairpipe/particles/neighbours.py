"""Particles near each other now, and the density (1) of Bando, Chen, Nishita 2003: rho_i = sum_j m_j W(r_ij, h_2).

Space is cut into cells of 2 h_2, in which particles are counted and sorted; where hair is so far apart that there would
be many more cells than particles, cells are larger. Pairs come in the order of cells, which no thread changes.
"""

import numpy as np
from numba import njit

from hairpipe.particles.smoothing_kernel import shape

CELLS = 4
"""Cells a particle, at most."""


@njit(cache=True, error_model="numpy")
def near_pairs(points: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return all pairs nearer than a distance [m], (P, 2) int32, and how far apart they are [m], (P,); pure."""
    order, first, counts = _sorted_into_cells(points, distance)
    nx, ny, nz = counts
    place = np.empty(points.shape)
    for a in range(len(order)):
        for c in range(3):
            place[a, c] = points[order[a], c]
    room = 16 * len(points) + 64
    pairs, apart, found = np.empty((room, 2), np.int32), np.empty(room), 0
    most = distance * distance
    for cx in range(nx):
        for cy in range(ny):
            for cz in range(nz):
                cell = (cx * ny + cy) * nz + cz
                for a in range(first[cell], first[cell + 1]):
                    # The rest of its own cell and the next; then rows of three cells on one side.
                    for side in range(5):
                        begin, end = a + 1, first[min(cell + 1, (cx * ny + cy) * nz + nz - 1) + 1]
                        if side > 0:
                            x = cx if side == 1 else cx + 1
                            y = cy + 1 if side == 1 else cy + side - 3
                            if x >= nx or y < 0 or y >= ny:
                                continue
                            line = (x * ny + y) * nz
                            begin, end = first[line + max(cz - 1, 0)], first[line + min(cz + 1, nz - 1) + 1]
                        if found + end - begin >= len(pairs):
                            pairs, apart = _longer(pairs, apart, end - begin)
                        for b in range(begin, end):
                            u = place[b, 0] - place[a, 0]
                            v = place[b, 1] - place[a, 1]
                            w = place[b, 2] - place[a, 2]
                            square = u * u + v * v + w * w
                            pairs[found, 0], pairs[found, 1] = order[a], order[b]
                            apart[found] = square
                            found += square < most  # always written, and kept or not: no branch to be guessed
    for k in range(found):
        apart[k] = np.sqrt(apart[k])
    return pairs[:found], apart[:found]


@njit(cache=True)
def _longer(pairs, apart, more):
    """Return both with room for as many again, and more."""
    longer, far = np.empty((2 * len(pairs) + more, 2), np.int32), np.empty(2 * len(pairs) + more)
    for k in range(len(pairs)):
        longer[k, 0], longer[k, 1], far[k] = pairs[k, 0], pairs[k, 1], apart[k]
    return longer, far


@njit(cache=True, error_model="numpy")
def _sorted_into_cells(points, size):
    """Return particles cell by cell, where each begins, and how many there are along the axes; z goes fastest."""
    low, high = np.empty(3), np.empty(3)
    for c in range(3):
        low[c], high[c] = np.inf, -np.inf
        for k in range(len(points)):
            low[c], high[c] = min(low[c], points[k, c]), max(high[c], points[k, c])
    while True:
        nx, ny, nz = (
            (high[0] - low[0]) // size + 1.0,
            (high[1] - low[1]) // size + 1.0,
            (high[2] - low[2]) // size + 1.0,
        )
        if nx * ny * nz <= CELLS * len(points) + 64:
            break
        size *= 2.0
    x, y, z = np.int64(nx), np.int64(ny), np.int64(nz)
    cells, first = np.empty(len(points), np.int64), np.zeros(x * y * z + 1, np.int64)
    over = 1.0 / size
    for k in range(len(points)):
        a = min(np.int64((points[k, 0] - low[0]) * over), x - 1)
        b = min(np.int64((points[k, 1] - low[1]) * over), y - 1)
        c = min(np.int64((points[k, 2] - low[2]) * over), z - 1)
        cells[k] = (a * y + b) * z + c
        first[cells[k] + 1] += 1
    for cell in range(x * y * z):
        first[cell + 1] += first[cell]
    order, filled = np.empty(len(points), np.int64), np.zeros(len(first), np.int64)
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
        density[k] = 4.0 * scale * masses[k]
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
    by, filled = np.empty(2 * len(pairs), np.int32), np.zeros(count, np.int32)
    for k in range(len(pairs)):
        for end in range(2):
            particle = pairs[k, end]
            by[rows[particle] + filled[particle]] = k
            filled[particle] += 1
    return rows, by
