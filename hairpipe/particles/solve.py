"""The linear system of a step, by conjugate gradients preconditioned with symmetric Gauss-Seidel sweeps.

    A = L + D + L^T = diag(D_i) - sum over links of B_e,   B_e = a d d^T + b,   D_i = m_i + dt C_i + sum of B_e

is symmetric and positive definite. With M = (D + L) D^-1 (D + L^T) conjugate gradients take less than half of the
iterations that they do with the blocks D alone; after Eisenstat, Efficient implementation of a class of preconditioned
conjugate gradient methods, 1981, they cost no more each, as for r = (D + L) s, x = (D + L^T)^-1 y

    (D + L)^-1 A (D + L^T)^-1 p = t + (D + L)^-1 (p - D t),   t = (D + L^T)^-1 p.

Particles that a body holds do not move along its normal n: their rows are those of A across n, as in Baraff and Witkin,
Large steps in cloth simulation, 1998. Sweeps go through particles in their order, on one thread. Vectors are in single
precision, since memory is what they cost; what they add to is not.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd_vec4 import dot, item, load_four, zeros
from hairpipe.kernels.vec3 import Vector
from hairpipe.particles.model import Links

MOST = 500
"""Iterations."""
DELAY = 2
"""Iterations whose gains are the error before them."""


class System(NamedTuple):
    """A system, in fours of float32, flat.

    links     that join particles
    deep      particles that are not solved for, which come first
    blocks    D_i of every particle: xx xy xz yy yz zz, (N, 6) float64
    joins     sqrt(a) d and b of every link, (4 E,)
    inverses  of the D_i, (N, 6) float32
    normals   unit vectors along which particles do not move; 0 where they are free, (N, 3) float64
    """

    links: Links
    deep: int
    blocks: np.ndarray
    joins: np.ndarray
    inverses: np.ndarray
    normals: np.ndarray


@njit(cache=True, error_model="numpy")
def solve(system: System, residual: np.ndarray, change: np.ndarray, tolerance: float, still: float) -> int:
    """Solve A x = b on; return how many iterations that took.

    residual   b - A x, (4 N,) float32
    change     x, the same; changed in place
    tolerance  of the error over the change, both in the norm of A
    still      square of an error in that norm that is as good as none

    An iteration takes step r . M^-1 r from the square of the error; the last DELAY of them together tell what it was
    before them, after Hestenes and Stiefel, Methods of conjugate gradients for solving linear systems, 1952. A residual
    alone does not: the more particles a hair has, the more of the error is in what moves all of it.
    """
    deep, count = system.deep, len(system.blocks)
    s, t, p, q = (np.zeros_like(change), np.zeros_like(change), np.zeros_like(change), np.zeros_like(change))
    sweep_down(system, residual, s)
    rz, before, made = 0.0, np.inf, 0
    for k in range(deep, count):
        rz += _dot(s, times_block(system.blocks, s, k), k)
    gains, total = np.zeros(DELAY), 0.0
    while rz > 0.0 and made < MOST:
        _sweep_up(system, s, np.float32(rz / before), p, t, q)
        sweep_down(system, q, q)
        pq = 0.0
        for k in range(4 * deep, 4 * count):
            q[k] += t[k]
            pq += np.float64(p[k]) * q[k]
        step = np.float32(rz / pq)
        gains[made % DELAY] = step * rz
        total += step * rz
        before, rz, made = rz, 0.0, made + 1
        for k in range(deep, count):
            for c in range(4 * k, 4 * k + 3):
                change[c] += step * t[c]
                s[c] -= step * q[c]
            rz += _dot(s, times_block(system.blocks, s, k), k)
        if made >= DELAY and not gains[0] + gains[1] > max(tolerance * tolerance * total, still):
            break
    return made


@njit(cache=True, error_model="numpy")
def sweep_down(system: System, r: np.ndarray, s: np.ndarray) -> None:
    """Write (D + L)^-1 r, (4 N,) float32, in place; both may be one."""
    links = system.links
    for k in range(system.deep, len(system.blocks)):
        across = _across(system, links.rows[k], links.mids[k], s, k)
        x, y, z = r[4 * k] + across[0], r[4 * k + 1] + across[1], r[4 * k + 2] + across[2]
        s[4 * k], s[4 * k + 1], s[4 * k + 2] = times(system.inverses, k, x, y, z)


@njit(cache=True, error_model="numpy")
def _sweep_up(system, s, turn, p, t, q):
    """Write the next p = D s + turn p, t = (D + L^T)^-1 p, and p - D t to q, (4 N,) float32, in place."""
    links = system.links
    for k in range(len(system.blocks) - 1, system.deep - 1, -1):
        across, more = _across(system, links.mids[k], links.rows[k + 1], t, k), times_block(system.blocks, s, k)
        for c in range(3):
            p[4 * k + c] = more[c] + turn * p[4 * k + c]
            q[4 * k + c] = -across[c]
        x, y, z = p[4 * k] + across[0], p[4 * k + 1] + across[1], p[4 * k + 2] + across[2]
        t[4 * k], t[4 * k + 1], t[4 * k + 2] = times(system.inverses, k, x, y, z)


@njit(cache=True, error_model="numpy")
def take_off(system: System, change: np.ndarray, residual: np.ndarray) -> None:
    """Take A x from a residual, (4 N,) float32 each, in place."""
    links = system.links
    for k in range(system.deep, len(system.blocks)):
        mine, others = (
            times_block(system.blocks, change, k),
            _gathered(system, links.rows[k], links.rows[k + 1], change),
        )
        for c in range(3):
            residual[4 * k + c] -= mine[c] - others[c]


@inlined
def _gathered(system, begin, end, v):
    """Return the sum of B v over links of a particle, from one to another of its row."""
    across = zeros()
    for at in range(begin, end):
        other, join = load_four(v, 4 * system.links.others[at]), load_four(system.joins, 4 * system.links.by[at])
        across = across + join * dot(other, join) + other * item(join, 3)
    return item(across, 0), item(across, 1), item(across, 2)


@inlined
def _across(system, begin, end, v, k):
    """Return the same across the normal of particle k."""
    x, y, z = _gathered(system, begin, end, v)
    n = system.normals
    nx, ny, nz = np.float32(n[k, 0]), np.float32(n[k, 1]), np.float32(n[k, 2])
    along = x * nx + y * ny + z * nz
    return x - along * nx, y - along * ny, z - along * nz


@inlined
def times(matrices, k, x, y, z):
    """Return the symmetric matrix k times a vector, in float32."""
    u = np.float32(matrices[k, 0] * x + matrices[k, 1] * y + matrices[k, 2] * z)
    v = np.float32(matrices[k, 1] * x + matrices[k, 3] * y + matrices[k, 4] * z)
    return u, v, np.float32(matrices[k, 2] * x + matrices[k, 4] * y + matrices[k, 5] * z)


@inlined
def times_block(matrices: np.ndarray, v: np.ndarray, k: int) -> Vector:
    """Return the symmetric matrix k times what particle k has of v, (4 N,) float32."""
    return times(matrices, k, v[4 * k], v[4 * k + 1], v[4 * k + 2])


@inlined
def _dot(v, u, k):
    """Return the scalar product of what particle k has of v with u, in double precision."""
    return np.float64(v[4 * k]) * u[0] + np.float64(v[4 * k + 1]) * u[1] + np.float64(v[4 * k + 2]) * u[2]


@njit(cache=True, error_model="numpy")
def inverted(blocks: np.ndarray) -> np.ndarray:
    """Return the inverses of symmetric blocks, (N, 6) float64, in float32; pure."""
    inverses = np.empty(blocks.shape, np.float32)
    for k in range(len(blocks)):
        _invert(blocks, k, inverses)
    return inverses


@inlined
def _invert(blocks, k, inverses):
    """Write the inverse of block k, in place."""
    a, b, c, d, e, f = blocks[k, 0], blocks[k, 1], blocks[k, 2], blocks[k, 3], blocks[k, 4], blocks[k, 5]
    A, B, C = d * f - e * e, c * e - b * f, b * e - c * d
    over = 1.0 / (a * A + b * B + c * C)
    inverses[k, 0], inverses[k, 1], inverses[k, 2] = over * A, over * B, over * C
    inverses[k, 3] = over * (a * f - c * c)
    inverses[k, 4] = over * (b * c - a * e)
    inverses[k, 5] = over * (a * d - b * b)


@inlined
def yielding(inverses: np.ndarray, k: int, n: Vector) -> float:
    """Return by how much particle k, alone, gives way along a unit vector to an impulse along it [1/kg]."""
    x, y, z = n
    B = inverses[k]
    return B[0] * x * x + B[3] * y * y + B[5] * z * z + 2.0 * (B[1] * x * y + B[2] * x * z + B[4] * y * z)


@inlined
def hold(system: System, k: int, n: Vector, damper: float) -> None:
    """Hold particle k along a unit vector, and add a damper [kg] across it, in place."""
    B = system.blocks
    a = B[k, 0] * n[0] + B[k, 1] * n[1] + B[k, 2] * n[2]
    b = B[k, 1] * n[0] + B[k, 3] * n[1] + B[k, 4] * n[2]
    c = B[k, 2] * n[0] + B[k, 4] * n[1] + B[k, 5] * n[2]
    D = (a, b, c)  # D n; across n is D - n (D n)^T - (D n) n^T + n (n . D n) n^T, and along it n (n . D n) n^T
    along = 2.0 * (a * n[0] + b * n[1] + c * n[2]) - damper
    at = 0
    for i in range(3):
        for j in range(i, 3):
            B[k, at] += along * n[i] * n[j] - n[i] * D[j] - D[i] * n[j] + (damper if i == j else 0.0)
            system.normals[k, i] = n[i]
            at += 1
    _invert(B, k, system.inverses)
