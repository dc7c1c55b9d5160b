"""Forces and stiffness of the springs of a mesh, added to a right-hand side and a sparse matrix.

Every spring is one direction n with weights g_i of its particles, a force f n g_i and a stiffness s g_i g_j n n^T; a
linear spring has its tension term besides, as in `stretch.py`. Directions, weights and forces of altitude
springs are found eight at a time, one in each lane; what is shared by particles is then added in order, so that a
result does not depend on threads.
"""

import math

import numpy as np
from numba import njit

from hairpipe.geometry.simd import load, maximum, store
from hairpipe.geometry.vec3 import dot
from hairpipe.graphs.experiments.elastic.spring_mesh import Springs
from hairpipe.laws.altitude import altitude_along, area_vectors, shortest_altitude

FIELDS = 9
"""Numbers that say what an altitude spring does: four weights, a direction, a force per unit stiffness, a stiffness."""
_SMALLEST = 1e-12  # [m]; a shorter spring has no direction


@njit(cache=True)
def _gather(corners: np.ndarray, x: np.ndarray, fours: np.ndarray, block: int) -> None:
    """Lay the particles of a block of fours in lanes, (4, 3, W), in place."""
    for lane in range(corners.shape[2]):
        for i in range(4):
            p = fours[block * corners.shape[2] + lane, i]
            for c in range(3):
                corners[i, c, lane] = x[p, c]


@njit(cache=True)
def _side(corners, i):
    x = load(corners, (i, 0)) - load(corners, (0, 0))
    y = load(corners, (i, 1)) - load(corners, (0, 1))
    return x, y, load(corners, (i, 2)) - load(corners, (0, 2))


@njit(cache=True)
def _write(found, row, weights, n, height, rest, press, least):
    """Write what one altitude does: force -k (h - h0) / max(|h0|, least)."""
    stiffness = press / maximum(maximum(rest, -rest), least)
    store(found, (row, 0), weights[0])
    store(found, (row, 1), weights[1])
    store(found, (row, 2), weights[2])
    store(found, (row, 3), weights[3])
    store(found, (row, 4), n[0])
    store(found, (row, 5), n[1])
    store(found, (row, 6), n[2])
    store(found, (row, 7), rest - height)
    store(found, (row, 8), stiffness)


@njit(cache=True)
def find_altitudes(found: np.ndarray, x: np.ndarray, springs: Springs) -> None:
    """Find what the altitude springs do, in place.

    found  (altitudes * blocks, FIELDS, W): block after block for every face, where all of them act
    x      positions [m], (n, 3)
    """
    blocks = len(springs.presses)
    corners = np.empty((4, 3, springs.presses.shape[1]))
    for block in range(blocks):
        _gather(corners, x, springs.fours, block)
        u, v, w = _side(corners, 1), _side(corners, 2), _side(corners, 3)
        heights = springs.heights
        press = load(springs.presses, (block,))
        least = load(springs.least, (block,))
        h0, h1, h2 = load(heights, (block, 0)), load(heights, (block, 1)), load(heights, (block, 2))
        h3, h4, h5, h6 = (
            load(heights, (block, 3)),
            load(heights, (block, 4)),
            load(heights, (block, 5)),
            load(heights, (block, 6)),
        )
        if springs.altitudes == 1:
            weights, n, height, rest = shortest_altitude(u, v, w, (h0, h1, h2, h3, h4, h5, h6))
            _write(found, block, weights, n, height, rest, press, least)
        elif springs.altitudes == 4:
            areas = area_vectors(u, v, w)
            n0, n1, n2, n3 = areas
            weights, n, height = altitude_along(areas, n0, dot(n0, n0), u)
            _write(found, block, weights, n, height, h0, press, least)
            weights, n, height = altitude_along(areas, n1, dot(n1, n1), u)
            _write(found, blocks + block, weights, n, height, h1, press, least)
            weights, n, height = altitude_along(areas, n2, dot(n2, n2), u)
            _write(found, 2 * blocks + block, weights, n, height, h2, press, least)
            weights, n, height = altitude_along(areas, n3, dot(n3, n3), u)
            _write(found, 3 * blocks + block, weights, n, height, h3, press, least)


@njit(cache=True)
def add_altitudes(A, b, x, v, springs, h, damping):
    """Add h f to b and (h^2 + h damping) K to A, in place.

    A        blocks of the matrix, (blocks, 3, 3); b  (n, 3)
    x, v     positions [m] and velocities [m/s], (n, 3)
    h        step [s]; damping  time over which stiffness damps [s]
    """
    blocks, W = springs.presses.shape
    found = np.empty((springs.altitudes * blocks, FIELDS, W))
    find_altitudes(found, x, springs)
    g, n = np.empty(4), np.empty(3)
    for row in range(len(found)):
        for lane in range(W):
            t = (row % blocks) * W + lane
            stiffness = found[row, 8, lane]
            if stiffness == 0.0:
                continue
            for i in range(4):
                g[i] = found[row, i, lane]
            for c in range(3):
                n[c] = found[row, 4 + c, lane]
            rate = 0.0
            for i in range(4):
                p = springs.fours[t, i]
                rate += g[i] * (n[0] * v[p, 0] + n[1] * v[p, 1] + n[2] * v[p, 2])
            force = h * stiffness * (found[row, 7, lane] - damping * rate)
            for i in range(4):
                p = springs.fours[t, i]
                for c in range(3):
                    b[p, c] += force * g[i] * n[c]
                for j in range(4):
                    block = springs.pattern.by_four[t, 4 * i + j]
                    s = (h * h + h * damping) * stiffness * g[i] * g[j]
                    for c in range(3):
                        for d in range(3):
                            A[block, c, d] += s * n[c] * n[d]


@njit(cache=True)
def _direction(x, p, q):
    dx, dy, dz = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    inverse = 1.0 / max(length, _SMALLEST)
    return dx * inverse, dy * inverse, dz * inverse, length


@njit(cache=True)
def add_linear(A, b, x, v, T, springs, h, damping):
    """Add h f to b and h^2 K + h D to A for the linear springs, in place; T  their multipliers [N], (e,)."""
    block = np.empty((3, 3))
    d = np.empty(3)
    for e in range(len(springs.pairs)):
        p, q = springs.pairs[e]
        d[0], d[1], d[2], length = _direction(x, p, q)
        k, inverse = springs.pulls[e], springs.inverse[e]
        rate = d[0] * (v[q, 0] - v[p, 0]) + d[1] * (v[q, 1] - v[p, 1]) + d[2] * (v[q, 2] - v[p, 2])
        force = h * k * (inverse * (length + damping * rate) - 1.0)
        tension = h * h * max(T[e], 0.0) / max(length, _SMALLEST)
        along = (h * h + h * damping) * k * inverse - tension
        for c in range(3):
            b[p, c] += force * d[c]
            b[q, c] -= force * d[c]
            for r in range(3):
                block[c, r] = along * d[c] * d[r] + (tension if c == r else 0.0)
        for c in range(3):
            for r in range(3):
                A[springs.pattern.by_pair[e, 0], c, r] += block[c, r]
                A[springs.pattern.by_pair[e, 1], c, r] -= block[c, r]
                A[springs.pattern.by_pair[e, 2], c, r] -= block[c, r]
                A[springs.pattern.by_pair[e, 3], c, r] += block[c, r]


@njit(cache=True)
def find_forces(f, x, springs):
    """Add the force of every spring [N] at positions x [m] to f, both (n, 3), in place."""
    A = np.zeros((len(springs.pattern.column), 3, 3))
    still = np.zeros_like(x)
    T = np.zeros(len(springs.pairs))
    add_linear(A, f, x, still, T, springs, 1.0, 0.0)
    add_altitudes(A, f, x, still, springs, 1.0, 0.0)


@njit(cache=True)
def find_tensions(T, x, dx, springs):
    """Set the multipliers to those of a solution dx [m] linearised at x [m], in place."""
    for e in range(len(springs.pairs)):
        p, q = springs.pairs[e]
        ux, uy, uz, length = _direction(x, p, q)
        along = ux * (dx[q, 0] - dx[p, 0]) + uy * (dx[q, 1] - dx[p, 1]) + uz * (dx[q, 2] - dx[p, 2])
        T[e] = springs.pulls[e] * (springs.inverse[e] * (length + along) - 1.0)


@njit(cache=True)
def spring_energy(x, springs):
    """Energy of all springs [J] at x (n, 3): k (l - l0)^2 / (2 l0) and k (h - h0)^2 / (2 max(|h0|, least))."""
    total = 0.0
    for e in range(len(springs.pairs)):
        p, q = springs.pairs[e]
        stretch = _direction(x, p, q)[3] * springs.inverse[e] - 1.0
        total += 0.5 * springs.pulls[e] / springs.inverse[e] * stretch * stretch
    found = np.empty((springs.altitudes * len(springs.presses), FIELDS, springs.presses.shape[1]))
    find_altitudes(found, x, springs)
    for row in range(len(found)):
        for lane in range(found.shape[2]):
            total += 0.5 * found[row, 8, lane] * found[row, 7, lane] ** 2
    return total
