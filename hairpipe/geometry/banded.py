"""Direct solution of one banded system per strand, a block of strands at a time.

The matrix is symmetric positive definite with 3 x 3 blocks and couples a particle to the next few, its reach: three in
the network (block-heptadiagonal), two in a plain chain. Row p of an array A (p, 6 + 9 reach, W) holds

    A[p, 0:6]                D_p      upper triangle xx xy xz yy yz zz of the block on the diagonal
    A[p, OFFSET + 9 (o-1)]   U_p,o    block (p, p+o) row by row, o = 1 ... reach

Elimination may follow assembly row by row, since a finished row p depends on earlier rows only:

    W_o = D_p^-1 U_p,o,   A_(p+a, p+b) -= U_p,a^T W_b,   b_(p+a) -= U_p,a^T D_p^-1 b_p

It leaves W in place of U and D^-1 in place of D. About 250 multiply-adds a particle at reach 3; nothing is pivoted.
"""

import numpy as np
from numba.extending import register_jitable

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import load, load_as, select, store
from hairpipe.geometry.vec3 import dot

OFFSET = 6


@register_jitable
def row_size(reach: int) -> int:
    """Numbers in a row of A; for kernels and for Python."""
    return OFFSET + 9 * reach


@inlined
def clear_row(A: np.ndarray, p: int) -> None:
    """Set row p to zero, in place."""
    for c in range(A.shape[1]):
        store(A, (p, c), 0.0)


@inlined
def add(A, p, c, value):
    """Add lanes to entry c of row p, in place."""
    store(A, (p, c), load(A, (p, c)) + value)


@inlined
def add_diagonal(A, p, xx, xy, xz, yy, yz, zz):
    """Add a symmetric block to D_p, in place."""
    add(A, p, 0, xx)
    add(A, p, 1, xy)
    add(A, p, 2, xz)
    add(A, p, 3, yy)
    add(A, p, 4, yz)
    add(A, p, 5, zz)


@inlined
def add_coupling(A, p, offset, block):
    """Add a symmetric block, a tuple of six, to U_p,offset, in place."""
    xx, xy, xz, yy, yz, zz = block
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


@inlined
def fix_row(A, b, p):
    """Make the unknowns of particle p zero, in place: nothing of its row reaches later rows."""
    clear_row(A, p)
    for c in range(b.shape[1]):
        store(b, (p, c), 0.0)


@inlined
def fix_lanes(A, b, p, fixed):
    """Make the unknown of particle p zero in the lanes of a mask, in place."""
    for c in range(A.shape[1]):
        unit = 1.0 if c == 0 or c == 3 or c == 5 else 0.0
        store(A, (p, c), select(fixed, unit, load(A, (p, c))))
    for c in range(3):
        store(b, (p, c), select(fixed, 0.0, load(b, (p, c))))


@inlined
def _invert(A, p):
    """Replace D_p by its inverse, by cofactors, and return that."""
    xx, xy, xz = load(A, (p, 0)), load(A, (p, 1)), load(A, (p, 2))
    yy, yz, zz = load(A, (p, 3)), load(A, (p, 4)), load(A, (p, 5))
    cxx = yy * zz - yz * yz
    cxy = xz * yz - xy * zz
    cxz = xy * yz - xz * yy
    s = 1.0 / (xx * cxx + xy * cxy + xz * cxz)  # One division for all six: it is as slow as many multiplications.
    iyy, iyz, izz = (xx * zz - xz * xz) * s, (xy * xz - xx * yz) * s, (xx * yy - xy * xy) * s
    inverse = cxx * s, cxy * s, cxz * s, iyy, iyz, izz
    for c in range(6):
        store(A, (p, c), inverse[c])
    return _rows_of(inverse)


@inlined
def _rows_of(six):
    return (six[0], six[1], six[2]), (six[1], six[3], six[4]), (six[2], six[4], six[5])


@inlined
def _times(rows, vector):
    return dot(rows[0], vector), dot(rows[1], vector), dot(rows[2], vector)


@inlined
def _columns(A, p, offset):
    """Columns of U_p,offset."""
    c = OFFSET + 9 * (offset - 1)
    return (
        (load(A, (p, c)), load(A, (p, c + 3)), load(A, (p, c + 6))),
        (load(A, (p, c + 1)), load(A, (p, c + 4)), load(A, (p, c + 7))),
        (load(A, (p, c + 2)), load(A, (p, c + 5)), load(A, (p, c + 8))),
    )


@inlined
def _solve_columns(A, p, offset, inverse, u):
    """Replace U_p,offset by W = D_p^-1 U, and return its columns."""
    w = _times(inverse, u[0]), _times(inverse, u[1]), _times(inverse, u[2])
    c = OFFSET + 9 * (offset - 1)
    for i in range(3):
        for j in range(3):
            store(A, (p, c + 3 * i + j), w[j][i])
    return w


@inlined
def _take_product(target, p, c, a, b):
    store(target, (p, c), load(target, (p, c)) - dot(a, b))


@inlined
def _take_vector(b, p, u, x):
    """b_p -= U^T x."""
    for i in range(3):
        _take_product(b, p, i, u[i], x)


@inlined
def _take_diagonal(A, p, u, w):
    """D_p -= U^T W."""
    for j in range(3):
        _take_product(A, p, j, u[0], w[j])
    _take_product(A, p, 3, u[1], w[1])
    _take_product(A, p, 4, u[1], w[2])
    _take_product(A, p, 5, u[2], w[2])


@inlined
def _take_coupling(A, p, offset, u, w):
    """U_p,offset -= U^T W."""
    for i in range(3):
        for j in range(3):
            _take_product(A, p, OFFSET + 9 * (offset - 1) + 3 * i + j, u[i], w[j])


@inlined
def eliminate(A, b, p, count, reach):
    """Eliminate particle p from the rows after it, in place.

    A      (particles, 6 + 9 reach, W), complete up to row p
    b      right-hand side (particles, 3, W)
    count  number of particles
    """
    # Blocks of the row are read once and stay in registers, since LLVM assumes that written memory may be read.
    inverse = _invert(A, p)
    x = _times(inverse, (load(b, (p, 0)), load(b, (p, 1)), load(b, (p, 2))))
    _store_vector(b, p, x)
    # Written out for a reach of up to three, so that the blocks U of a row stay in registers for all products.
    after = min(reach, count - 1 - p)
    if after > 0:
        u1 = _columns(A, p, 1)
        w = _solve_columns(A, p, 1, inverse, u1)
        _take_vector(b, p + 1, u1, x)
        _take_diagonal(A, p + 1, u1, w)
        if after > 1:
            u2 = _columns(A, p, 2)
            w = _solve_columns(A, p, 2, inverse, u2)
            _take_vector(b, p + 2, u2, x)
            _take_coupling(A, p + 1, 1, u1, w)
            _take_diagonal(A, p + 2, u2, w)
            if after > 2:
                u3 = _columns(A, p, 3)
                w = _solve_columns(A, p, 3, inverse, u3)
                _take_vector(b, p + 3, u3, x)
                _take_coupling(A, p + 1, 2, u1, w)
                _take_coupling(A, p + 2, 1, u2, w)
                _take_diagonal(A, p + 3, u3, w)


@inlined
def forward(A, b, p, count, reach):
    """Eliminate particle p from another right-hand side, as `eliminate`, in place.

    A  factors, which may be kept in less precision than b
    """
    x = load(b, (p, 0)), load(b, (p, 1)), load(b, (p, 2))
    for o in range(1, min(reach, count - 1 - p) + 1):
        w = OFFSET + 9 * (o - 1)  # A now holds W, and U^T D^-1 = W^T
        for c in range(3):
            _take_product(b, p + o, c, _three(A, p, w + c, 3, x[0]), x)
    # Last, as the rows after it take b as it was before the product with D^-1.
    xx, xy, xz = load_as(A, (p, 0), x[0]), load_as(A, (p, 1), x[0]), load_as(A, (p, 2), x[0])
    yy, yz, zz = load_as(A, (p, 3), x[0]), load_as(A, (p, 4), x[0]), load_as(A, (p, 5), x[0])
    _store_vector(b, p, _times(_rows_of((xx, xy, xz, yy, yz, zz)), x))


@inlined
def _store_vector(b, p, x):
    for c in range(3):
        store(b, (p, c), x[c])


@inlined
def _three(A, p, c, step, like):
    return load_as(A, (p, c), like), load_as(A, (p, c + step), like), load_as(A, (p, c + 2 * step), like)


@inlined
def substitute(A, b, count, reach):
    """Replace b by the solution, in place, after every row has been eliminated; A may be kept in less precision."""
    for p in range(count - 1, -1, -1):  # From the tip to the root: a row depends on later rows only.
        x, y, z = load(b, (p, 0)), load(b, (p, 1)), load(b, (p, 2))
        for o in range(1, min(reach, count - 1 - p) + 1):
            w = OFFSET + 9 * (o - 1)
            s = load(b, (p + o, 0)), load(b, (p + o, 1)), load(b, (p + o, 2))
            x = x - dot(_three(A, p, w, 1, x), s)
            y = y - dot(_three(A, p, w + 3, 1, x), s)
            z = z - dot(_three(A, p, w + 6, 1, x), s)
        _store_vector(b, p, (x, y, z))
