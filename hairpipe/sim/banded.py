"""Direct solution of one block-heptadiagonal system per strand, eight strands at a time.

The matrix is symmetric positive definite with 3 x 3 blocks and couples a particle to the next three. Row p of an
array A (p, ROW, WIDTH) holds

    A[p, 0:6]                D_p      upper triangle xx xy xz yy yz zz of the block on the diagonal
    A[p, OFFSET + 9 (o-1)]   U_p,o    block (p, p+o) row by row, o = 1, 2, 3

Elimination may follow assembly row by row, since a finished row p depends on earlier rows only:

    W_o = D_p^-1 U_p,o,   A_(p+a, p+b) -= U_p,a^T W_b,   b_(p+a) -= U_p,a^T D_p^-1 b_p

It leaves W in place of U and D^-1 in place of D. About 250 multiply-adds a particle; nothing is pivoted.
"""

import numpy as np
from numba import njit

from hairpipe.sim.lanes import load, store

REACH = 3
OFFSET = 6
ROW = OFFSET + 9 * REACH


@njit(cache=True)
def clear_row(A: np.ndarray, p: int) -> None:
    """Set row p to zero, in place."""
    for c in range(ROW):
        for lane in range(A.shape[2]):
            A[p, c, lane] = 0.0


@njit(cache=True)
def add(A, p, c, value):  # noqa: ANN001, ANN201
    """Add lanes to entry c of row p, in place."""
    store(A, (p, c), load(A, (p, c)) + value)


@njit(cache=True)
def add_diagonal(A, p, xx, xy, xz, yy, yz, zz):  # noqa: ANN001, ANN201
    """Add a symmetric block to D_p, in place."""
    add(A, p, 0, xx)
    add(A, p, 1, xy)
    add(A, p, 2, xz)
    add(A, p, 3, yy)
    add(A, p, 4, yz)
    add(A, p, 5, zz)


@njit(cache=True)
def add_coupling(A, p, offset, xx, xy, xz, yy, yz, zz):  # noqa: ANN001, ANN201
    """Add a symmetric block to U_p,offset, in place."""
    c = OFFSET + 9 * (offset - 1)
    add(A, p, c, xx)
    add(A, p, c + 1, xy)
    add(A, p, c + 2, xz)
    add(A, p, c + 3, xy)
    add(A, p, c + 4, yy)
    add(A, p, c + 5, yz)
    add(A, p, c + 6, xz)
    add(A, p, c + 7, yz)
    add(A, p, c + 8, zz)


@njit(cache=True)
def fix_row(A: np.ndarray, b: np.ndarray, p: int) -> None:
    """Make the unknown of particle p zero, in place: nothing of its row reaches later rows."""
    for c in range(ROW):
        for lane in range(A.shape[2]):
            A[p, c, lane] = 0.0
    for c in range(3):
        for lane in range(A.shape[2]):
            b[p, c, lane] = 0.0


@njit(cache=True)
def _invert(A, p):  # noqa: ANN001, ANN202
    """Replace D_p by its inverse, by cofactors."""
    xx, xy, xz = load(A, (p, 0)), load(A, (p, 1)), load(A, (p, 2))
    yy, yz, zz = load(A, (p, 3)), load(A, (p, 4)), load(A, (p, 5))
    cxx = yy * zz - yz * yz
    cxy = xz * yz - xy * zz
    cxz = xy * yz - xz * yy
    s = 1.0 / (xx * cxx + xy * cxy + xz * cxz)
    store(A, (p, 0), cxx * s)
    store(A, (p, 1), cxy * s)
    store(A, (p, 2), cxz * s)
    store(A, (p, 3), (xx * zz - xz * xz) * s)
    store(A, (p, 4), (xy * xz - xx * yz) * s)
    store(A, (p, 5), (xx * yy - xy * xy) * s)


@njit(cache=True)
def _apply_inverse(A, p, x, y, z):  # noqa: ANN001, ANN202
    """D_p^-1 times a vector, D_p already inverted."""
    xx, xy, xz = load(A, (p, 0)), load(A, (p, 1)), load(A, (p, 2))
    yy, yz, zz = load(A, (p, 3)), load(A, (p, 4)), load(A, (p, 5))
    return xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z


@njit(cache=True)
def eliminate(A, b, p, last):  # noqa: ANN001, ANN201
    """Eliminate particle p from the rows after it, in place.

    A     (particles, ROW, WIDTH), complete up to row p
    b     right-hand side (particles, 3, WIDTH)
    last  number of particles
    """
    _invert(A, p)
    x, y, z = _apply_inverse(A, p, load(b, (p, 0)), load(b, (p, 1)), load(b, (p, 2)))
    store(b, (p, 0), x)
    store(b, (p, 1), y)
    store(b, (p, 2), z)
    for o in range(1, min(REACH, last - 1 - p) + 1):
        u = OFFSET + 9 * (o - 1)
        # Column of unknowns p+o: one column of U at a time, so that W replaces it only when it is used up.
        for r in range(3):
            u0, u1, u2 = load(A, (p, u + r)), load(A, (p, u + 3 + r)), load(A, (p, u + 6 + r))
            store(b, (p + o, r), load(b, (p + o, r)) - (u0 * x + u1 * y + u2 * z))
    for o in range(min(REACH, last - 1 - p), 0, -1):
        u = OFFSET + 9 * (o - 1)
        for r in range(3):
            u0, u1, u2 = load(A, (p, u + r)), load(A, (p, u + 3 + r)), load(A, (p, u + 6 + r))
            w0, w1, w2 = _apply_inverse(A, p, u0, u1, u2)
            # A_(p+a, p+o)[i, r] -= U_a[:, i] . w for a < o, and the upper triangle of the block on the diagonal.
            for a in range(1, o):
                c = OFFSET + 9 * (o - a - 1) + r
                v = OFFSET + 9 * (a - 1)
                for i in range(3):
                    s = load(A, (p, v + i)) * w0 + load(A, (p, v + 3 + i)) * w1 + load(A, (p, v + 6 + i)) * w2
                    store(A, (p + a, c + 3 * i), load(A, (p + a, c + 3 * i)) - s)
            for i in range(r, 3):
                d = _upper(r, i)
                s = load(A, (p, u + i)) * w0 + load(A, (p, u + 3 + i)) * w1 + load(A, (p, u + 6 + i)) * w2
                store(A, (p + o, d), load(A, (p + o, d)) - s)
            store(A, (p, u + r), w0)
            store(A, (p, u + 3 + r), w1)
            store(A, (p, u + 6 + r), w2)


@njit(cache=True)
def _upper(row: int, column: int) -> int:
    """Place of entry (row, column >= row) in the six numbers of a symmetric block."""
    return column if row == 0 else row + column + 1


@njit(cache=True)
def substitute(A, b, last):  # noqa: ANN001, ANN201
    """Replace b by the solution, in place, after every row has been eliminated."""
    for p in range(last - 1, -1, -1):
        x, y, z = load(b, (p, 0)), load(b, (p, 1)), load(b, (p, 2))
        for o in range(1, min(REACH, last - 1 - p) + 1):
            w = OFFSET + 9 * (o - 1)
            sx, sy, sz = load(b, (p + o, 0)), load(b, (p + o, 1)), load(b, (p + o, 2))
            x = x - (load(A, (p, w)) * sx + load(A, (p, w + 1)) * sy + load(A, (p, w + 2)) * sz)
            y = y - (load(A, (p, w + 3)) * sx + load(A, (p, w + 4)) * sy + load(A, (p, w + 5)) * sz)
            z = z - (load(A, (p, w + 6)) * sx + load(A, (p, w + 7)) * sy + load(A, (p, w + 8)) * sz)
        store(b, (p, 0), x)
        store(b, (p, 1), y)
        store(b, (p, 2), z)
