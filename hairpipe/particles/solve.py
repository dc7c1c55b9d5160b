"""The linear system of a step, by conjugate gradients preconditioned with the blocks of particles.

    A = diag(D_i) - sum over links of B_e,   B_e = a d d^T + b,   D_i = m_i + dt C_i + sum of B_e

is symmetric and positive definite. Particles that a body holds are kept from moving along its normal: residuals and
directions of search are taken across it, after Baraff and Witkin, Large steps in cloth simulation, 1998. Each particle
sums its links in their order. Vectors are in single precision, since memory is what they cost; what they add to is not.
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
def solve(system: System, residual: np.ndarray, change: np.ndarray, size: float) -> int:
    """Solve A x = b on; return how many iterations that took.

    residual  b - A x, (4 N,) float32; changed in place
    change    x, the same; changed in place
    size      r . z at which it is solved
    """
    deep, count = system.deep, len(system.blocks)
    z, p, q = np.zeros_like(change), np.zeros_like(change), np.empty_like(change)
    before, made = 0.0, 0
    while True:
        rz = precondition(system, residual, z)
        if not rz > size or made == MOST:
            return made
        turn = np.float32(rz / before) if made > 0 else np.float32(0.0)
        for k in range(4 * deep, 4 * count):
            p[k] = z[k] + turn * p[k]
        pq = multiply(system, p, q)
        step = np.float32(rz / pq)
        for k in range(4 * deep, 4 * count):
            change[k] += step * p[k]
            residual[k] -= step * q[k]
        before, made = rz, made + 1


@njit(cache=True, error_model="numpy")
def multiply(system: System, p: np.ndarray, q: np.ndarray) -> float:
    """Write A p, (4 N,) float32, in place; return p . A p."""
    links, total = system.links, 0.0
    for k in range(system.deep, len(system.blocks)):
        across = zeros()
        for at in range(links.rows[k], links.rows[k + 1]):
            other, join = load_four(p, 4 * links.others[at]), load_four(system.joins, 4 * links.by[at])
            across = across + join * dot(other, join) + other * item(join, 3)
        x, y, z = p[4 * k], p[4 * k + 1], p[4 * k + 2]
        D = system.blocks
        u = np.float32(D[k, 0] * x + D[k, 1] * y + D[k, 2] * z) - item(across, 0)
        v = np.float32(D[k, 1] * x + D[k, 3] * y + D[k, 4] * z) - item(across, 1)
        w = np.float32(D[k, 2] * x + D[k, 4] * y + D[k, 5] * z) - item(across, 2)
        q[4 * k], q[4 * k + 1], q[4 * k + 2], q[4 * k + 3] = u, v, w, 0.0
        total += np.float64(x) * u + np.float64(y) * v + np.float64(z) * w
    return total


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


@njit(cache=True, error_model="numpy")
def yielding(inverses: np.ndarray, k: int, n: Vector) -> float:
    """Return by how much particle k, alone, gives way along a unit vector to an impulse along it [1/kg]."""
    x, y, z = n
    B = inverses[k]
    return B[0] * x * x + B[3] * y * y + B[5] * z * z + 2.0 * (B[1] * x * y + B[2] * x * z + B[4] * y * z)


@njit(cache=True, error_model="numpy")
def damp_across(system: System, k: int, n: Vector, damper: float) -> None:
    """Add a damper [kg] across a unit vector to particle k, in place."""
    x, y, z = n
    B = system.blocks[k]
    B[0] += damper * (1.0 - x * x)
    B[1] -= damper * x * y
    B[2] -= damper * x * z
    B[3] += damper * (1.0 - y * y)
    B[4] -= damper * y * z
    B[5] += damper * (1.0 - z * z)
    _invert(system.blocks, k, system.inverses)


@njit(cache=True, error_model="numpy")
def precondition(system: System, residual: np.ndarray, z: np.ndarray) -> float:
    """Write what every particle moves by, alone and across its normal, (4 N,) float32, in place; return r . z."""
    total = 0.0
    for k in range(system.deep, len(system.blocks)):
        total += _precondition(system, residual, k, z)
    return total


@inlined
def _precondition(system, r, k, z):
    """Write what particle k moves by, alone and across its normal, in place; return what that is along its residual."""
    normals, inverses = system.normals, system.inverses
    nx, ny, nz = np.float32(normals[k, 0]), np.float32(normals[k, 1]), np.float32(normals[k, 2])
    x, y, w = r[4 * k], r[4 * k + 1], r[4 * k + 2]
    along = x * nx + y * ny + w * nz
    x, y, w = x - along * nx, y - along * ny, w - along * nz
    u = inverses[k, 0] * x + inverses[k, 1] * y + inverses[k, 2] * w
    v = inverses[k, 1] * x + inverses[k, 3] * y + inverses[k, 4] * w
    t = inverses[k, 2] * x + inverses[k, 4] * y + inverses[k, 5] * w
    along = u * nx + v * ny + t * nz
    u, v, t = u - along * nx, v - along * ny, t - along * nz
    z[4 * k], z[4 * k + 1], z[4 * k + 2] = u, v, t
    return np.float64(x) * u + np.float64(y) * v + np.float64(w) * t
