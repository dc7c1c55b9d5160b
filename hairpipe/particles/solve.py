"""The linear system of a step, by conjugate gradients preconditioned with symmetric Gauss-Seidel sweeps.

    A = L + D + L^T = diag(D_i) - sum over links of B_e,   B_e = a d d^T + b,   D_i = m_i + dt C_i + sum of B_e

is symmetric and positive definite. With M = (D + L) D^-1 (D + L^T) conjugate gradients take less than half of the
iterations needed with the blocks D alone; after Eisenstat, Efficient implementation of a class of preconditioned
conjugate gradient methods, 1981, an iteration costs no more, as for r = (D + L) s, x = (D + L^T)^-1 y

    (D + L)^-1 A (D + L^T)^-1 p = t + (D + L)^-1 (p - D t),   t = (D + L^T)^-1 p.

Particles held by a body do not move along its normal n: their rows are those of A projected across n, as in Baraff and
Witkin, Large steps in cloth simulation, 1998, and D^-1 is 0 along n. Sweeps process particles in order, on one thread.
Vectors are in single precision, since their cost is memory traffic; the state they are added to is in double. They are
4-vectors whose last component is 0, like the columns of blocks.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import multiply_add
from hairpipe.geometry.simd_vec4 import dot_in_all, item, last_in_all, load_four, store_four, zeros
from hairpipe.geometry.vec3 import Vector, dot
from hairpipe.particles.model import Links

MOST = 500
"""Iterations."""
DELAY = 2
"""Iterations whose gains are the error before them."""
_PLACES, _ENTRIES = (0, 1, 2, 4, 5, 6, 8, 9, 10), (0, 1, 2, 1, 3, 4, 2, 4, 5)
"""Places of a symmetric matrix in its columns, and the number of six at each."""


class System(NamedTuple):
    """A system.

    links     links between particles
    deep      number of prescribed particles, which come first
    blocks    D_i of every particle, three columns of it, (12 N,) float32
    inverses  of the D_i, the same
    joins     sqrt(a) d and b of the links of every particle, ordered as `links.others`, (8 E,) float32
    """

    links: Links
    deep: int
    blocks: np.ndarray
    inverses: np.ndarray
    joins: np.ndarray


@njit(cache=True)
def build_system(links: Links, deep: int) -> System:
    """Make a system of so many particles and links, without numbers."""
    count = len(links.mids)
    joins = np.empty(4 * len(links.others), np.float32)
    return System(links, deep, np.zeros(12 * count, np.float32), np.zeros(12 * count, np.float32), joins)


@njit(cache=True, error_model="numpy")
def solve(system: System, residual: np.ndarray, change: np.ndarray, tolerance: float, still: float) -> int:
    """Continue the solution of A x = b; return the number of iterations.

    residual   b - A x, (4 N,) float32
    change     x, the same; changed in place
    tolerance  ratio of the error to the change, both in the norm of A
    still      square of a negligible error in that norm

    An iteration reduces the square of the error by step r . M^-1 r; the sum over the last DELAY iterations estimates
    the error before them, after Hestenes and Stiefel, Methods of conjugate gradients for solving linear systems, 1952.
    A residual alone does not suffice: the more particles a hair has, the more of the error is in modes that move
    all of it.
    """
    s, t, q = np.zeros_like(change), np.zeros_like(change), np.zeros_like(change)
    u, p = np.zeros_like(change), np.zeros_like(change)
    _sweep_down(system, residual, p, t, s)
    rz = _step(system, np.float32(0.0), change, (s, t, q, u))
    before = np.inf  # Makes the first direction u alone.
    made = 0
    gains = np.zeros(DELAY)
    total = 0.0
    while rz > 0.0 and made < MOST:
        _sweep_up(system, np.float32(rz / before), u, p, t, q)
        step = rz / _sweep_down(system, q, p, t, q)
        gains[made % DELAY] = step * rz
        total += step * rz
        before = rz
        made = made + 1
        rz = _step(system, np.float32(step), change, (s, t, q, u))
        if made >= DELAY and not gains[0] + gains[1] > max(tolerance * tolerance * total, still):
            break
    return made


@njit(cache=True, error_model="numpy")
def _sweep_down(system, r, p, t, s):
    """Write s = (D + L)^-1 r, in place, where r may be s; return p . (s + t)."""
    links = system.links
    total = 0.0
    for k in range(system.deep, len(links.mids)):  # In order, on one thread: a row needs the s of those before it.
        # The lower triangle, whose blocks are -B: their products are added.
        across = _gathered(system, links.rows[k], links.mids[k], s, load_four(r, 4 * k))
        mine = _times(system.inverses, k, across)
        store_four(s, 4 * k, mine)
        total += np.float64(item(dot_in_all(load_four(p, 4 * k), mine + load_four(t, 4 * k)), 0))
    return total


@njit(cache=True, error_model="numpy")
def _sweep_up(system, turn, u, p, t, q):
    """Write the next p = u + turn p, with u = D s; t = (D + L^T)^-1 p; and q = p - D t, in place."""
    links = system.links
    for k in range(len(links.mids) - 1, system.deep - 1, -1):
        across = _gathered(system, links.mids[k], links.rows[k + 1], t, zeros())  # Upper triangle; D t = p + across.
        mine = load_four(u, 4 * k) + load_four(p, 4 * k) * turn
        store_four(p, 4 * k, mine)
        store_four(q, 4 * k, -across)
        store_four(t, 4 * k, _times(system.inverses, k, mine + across))


@njit(cache=True, error_model="numpy")
def _step(system, step, change, vectors):
    """Go a step along t, and write what remains, s -= step (q + t), and u = D s, in place; return s . u."""
    s, t, q, u = vectors
    total = 0.0
    for k in range(system.deep, len(system.links.mids)):
        along = load_four(t, 4 * k)
        store_four(change, 4 * k, load_four(change, 4 * k) + along * step)
        mine = load_four(s, 4 * k) - (load_four(q, 4 * k) + along) * step
        under = _times(system.blocks, k, mine)
        store_four(s, 4 * k, mine)
        store_four(u, 4 * k, under)
        total += np.float64(item(dot_in_all(mine, under), 0))
    return total


@njit(cache=True, error_model="numpy")
def take_off(system: System, change: np.ndarray, residual: np.ndarray) -> None:
    """Subtract A x from a residual, (4 N,) float32 each, in place."""
    links = system.links
    for k in range(system.deep, len(links.mids)):
        others = _gathered(system, links.rows[k], links.rows[k + 1], change, load_four(residual, 4 * k))
        left = others - _times(system.blocks, k, load_four(change, 4 * k))
        for c in range(3):
            residual[4 * k + c] = item(left, c)


@inlined
def _gathered(system, begin, end, v, across):
    """Add the sum of B v over links of a particle, from one to another of its row; the last number is any."""
    for at in range(np.int64(begin), np.int64(end)):
        other = load_four(v, 4 * np.int64(system.links.others[at]))
        join = load_four(system.joins, 4 * at)
        across = multiply_add(join, dot_in_all(other, join), multiply_add(other, last_in_all(join), across))
    return across


@inlined
def _times(columns, k, v):
    """Return the symmetric matrix k times a vector."""
    a = load_four(columns, 12 * k)
    b = load_four(columns, 12 * k + 4)
    c = load_four(columns, 12 * k + 8)
    return multiply_add(c, zeros() + item(v, 2), multiply_add(b, zeros() + item(v, 1), a * item(v, 0)))


@inlined
def product(columns: np.ndarray, k: int, v: Vector) -> Vector:
    """Return a symmetric matrix, number k of those in columns, times a vector."""
    x, y, z = v
    a = columns[12 * k : 12 * k + 3]
    b = columns[12 * k + 4 : 12 * k + 7]
    c = columns[12 * k + 8 : 12 * k + 11]
    return a[0] * x + b[0] * y + c[0] * z, a[1] * x + b[1] * y + c[1] * z, a[2] * x + b[2] * y + c[2] * z


@njit(cache=True, error_model="numpy")
def set_blocks(system: System, blocks: np.ndarray) -> None:
    """Write the blocks that are solved for, (N, 6) float64, as `set_block`, in place."""
    for k in range(system.deep, len(blocks)):
        B = blocks[k]
        set_block(system, k, (B[0], B[1], B[2], B[3], B[4], B[5]))


@inlined
def set_block(system: System, k: int, block: tuple[float, float, float, float, float, float]) -> None:
    """Write a symmetric block, xx xy xz yy yz zz, and its inverse, in place."""
    a, b, c, d, e, f = block
    A, B, C = d * f - e * e, c * e - b * f, b * e - c * d
    over = 1.0 / (a * A + b * B + c * C)
    inverse = over * A, over * B, over * C, over * (a * f - c * c), over * (b * c - a * e), over * (a * d - b * b)
    for n in range(9):
        at = 12 * k + _PLACES[n]
        system.blocks[at] = block[_ENTRIES[n]]
        system.inverses[at] = inverse[_ENTRIES[n]]


@inlined
def hold(system: System, k: int, n: Vector, damper: float) -> None:
    """Hold particle k along a unit vector, and add a damper [kg] across it, in place."""
    B = system.blocks
    at = 12 * k
    D = product(B, k, n)  # D n; across n is D - n (D n)^T - (D n) n^T + n (n . D n) n^T, and along it n (n . D n) n^T
    along = 2.0 * dot(D, n) - damper
    block = (
        B[at] + along * n[0] * n[0] - 2.0 * n[0] * D[0] + damper,
        B[at + 1] + along * n[0] * n[1] - n[0] * D[1] - D[0] * n[1],
        B[at + 2] + along * n[0] * n[2] - n[0] * D[2] - D[0] * n[2],
        B[at + 5] + along * n[1] * n[1] - 2.0 * n[1] * D[1] + damper,
        B[at + 6] + along * n[1] * n[2] - n[1] * D[2] - D[1] * n[2],
        B[at + 10] + along * n[2] * n[2] - 2.0 * n[2] * D[2] + damper,
    )
    set_block(system, k, block)
    I = system.inverses  # D^-1 without what it gives along n: the particle takes no impulse there.
    u = product(system.inverses, k, n)
    most = dot(u, n)
    for i in range(3):
        for j in range(3):
            I[at + 4 * i + j] -= most * n[i] * n[j]
