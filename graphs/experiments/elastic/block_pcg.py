"""Conjugate gradients with the inverse of the blocks on the diagonal as preconditioner.

Sums run in the order of the particles, so a result does not depend on threads.
"""

import numpy as np
from numba import njit

from hairpipe.graphs.experiments.elastic.sparsity import Pattern, multiply


@njit(cache=True)
def _invert_diagonal(P: np.ndarray, A: np.ndarray, diagonal: np.ndarray, free: np.ndarray) -> None:
    """Invert the blocks on the diagonal without the rows and columns of held unknowns, in place; P (n, 3, 3)."""
    block = np.empty((3, 3))
    for i in range(len(diagonal)):
        for c in range(3):
            for d in range(3):
                held = free[i, c] * free[i, d]
                block[c, d] = A[diagonal[i], c, d] * held + (1.0 - held if c == d else 0.0)
        xx, xy, xz, yy, yz, zz = block[0, 0], block[0, 1], block[0, 2], block[1, 1], block[1, 2], block[2, 2]
        a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
        s = 1.0 / (xx * a + xy * b + xz * c)
        P[i, 0, 0], P[i, 0, 1], P[i, 0, 2] = a * s, b * s, c * s
        P[i, 1, 1], P[i, 1, 2], P[i, 2, 2] = (xx * zz - xz * xz) * s, (xy * xz - xx * yz) * s, (xx * yy - xy * xy) * s
        P[i, 1, 0], P[i, 2, 0], P[i, 2, 1] = P[i, 0, 1], P[i, 0, 2], P[i, 1, 2]


@njit(cache=True)
def _precondition(z: np.ndarray, P: np.ndarray, r: np.ndarray) -> float:
    """Set z to P r, in place, and give r . z."""
    total = 0.0
    for i in range(len(r)):
        for c in range(3):
            z[i, c] = P[i, c, 0] * r[i, 0] + P[i, c, 1] * r[i, 1] + P[i, c, 2] * r[i, 2]
            total += z[i, c] * r[i, c]
    return total


@njit(cache=True)
def solve(
    A: np.ndarray, b: np.ndarray, pattern: Pattern, free: np.ndarray, tolerance: float, most: int
) -> tuple[np.ndarray, np.ndarray, int]:
    """Solve A x = b for the unknowns that are free, the others being 0.

    A          blocks (blocks, 3, 3), symmetric positive definite
    b          (n, 3); free  1 or 0, (n, 3)
    tolerance  of the residual over b, both in the norm of the preconditioner
    most       iterations
    returns    x (n, 3), A x - b (n, 3), which is 0 but where an unknown is held, and the iterations made
    """
    P = np.empty((len(b), 3, 3))
    _invert_diagonal(P, A, pattern.diagonal, free)
    x = np.zeros_like(b)
    r = b * free
    z = np.empty_like(b)
    y = np.empty_like(b)
    rz = _precondition(z, P, r)
    p = z.copy()
    goal = tolerance * tolerance * rz
    made = 0
    while made < most and rz > goal:
        multiply(y, pattern.first, pattern.column, A, p)
        curvature = 0.0
        for i in range(len(b)):
            for c in range(3):
                curvature += p[i, c] * y[i, c]
        step = rz / curvature
        for i in range(len(b)):
            for c in range(3):
                x[i, c] += step * p[i, c]
                r[i, c] -= step * y[i, c] * free[i, c]
        before = rz
        rz = _precondition(z, P, r)
        for i in range(len(b)):
            for c in range(3):
                p[i, c] = z[i, c] + rz / before * p[i, c]
        made += 1
    multiply(y, pattern.first, pattern.column, A, x)
    return x, y - b, made
