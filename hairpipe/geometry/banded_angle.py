"""Direct solution of one banded system per strand whose nodes have a position and an angle: four unknowns a row.

The matrix is symmetric. A row of angle couples to the next row, one of position to the positions of the row after that,
too: beyond its own four unknowns a row reaches seven further ones, and elimination fills nothing else. Row p of an
array A (p, 38, W) holds the upper triangle of four rows, from the diagonal on, in the order x, y, z, angle of p, then
of p + 1, then x, y, z of p + 2:

    A[p, 0:11]   A[p, 11:21]   A[p, 21:30]   A[p, 30:38]

`eliminate` makes L D L^T of it, a row at a time as rows are complete, and leaves 1 / D on the diagonal and L^T next to
it: 164 multiply-adds a row, and 34 multiplications. Nothing is pivoted. Where a pivot is not positive the matrix is not
positive definite: its magnitude is used, so that later values are finite, and the least pivots are returned.
"""

from hairpipe.geometry.banded import add
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import load, load_as, maximum, minimum, select, store

SIZE = 38
UNKNOWNS = 4
_X, _Y, _Z, _ANGLE = 0, 11, 21, 30
"""Places of the diagonal in a row of A."""
_SQUARE = (0, 1, 2, 3, 11, 12, 13, 21, 22, 30)
"""Places of what couples the four unknowns of a row to each other."""
_LEAST = 1e-30


@inlined
def add_point(A, p, six):
    """Add a symmetric block, a tuple of six lanes, to the position of row p, in place."""
    for c in range(3):
        add(A, p, _X + c, six[c])
    add(A, p, _Y, six[3])
    add(A, p, _Y + 1, six[4])
    add(A, p, _Z, six[5])


@inlined
def fix_position(A, b, p):
    """Make the position of row p zero, in place; its angle is free."""
    for c in range(_ANGLE):
        store(A, (p, c), 1.0 if c in (_X, _Y, _Z) else 0.0)
    for c in range(3):
        store(b, (p, c), 0.0)


@inlined
def fix_lanes(A, b, p, fixed):
    """Make the unknowns of row p zero in the lanes of a mask, in place."""
    for c in range(SIZE):
        unit = 1.0 if c in (_X, _Y, _Z, _ANGLE) else 0.0
        store(A, (p, c), select(fixed, unit, load(A, (p, c))))
    for c in range(UNKNOWNS):
        store(b, (p, c), select(fixed, 0.0, load(b, (p, c))))


@inlined
def _seven(A, p, c):
    first = load(A, (p, c)), load(A, (p, c + 1)), load(A, (p, c + 2)), load(A, (p, c + 3))
    return (*first, load(A, (p, c + 4)), load(A, (p, c + 5)), load(A, (p, c + 6)))


@inlined
def _times(s, t):
    return s * t[0], s * t[1], s * t[2], s * t[3], s * t[4], s * t[5], s * t[6]


@inlined
def _less(t, s, u):
    """t - s u."""
    first = t[0] - s * u[0], t[1] - s * u[1], t[2] - s * u[2], t[3] - s * u[3]
    return (*first, t[4] - s * u[4], t[5] - s * u[5], t[6] - s * u[6])


@inlined
def _pivot(d, lowest):
    """Return the divisor of a pivot, and the lowest pivot so far."""
    return maximum(maximum(d, -d), _LEAST), minimum(d, lowest)


@inlined
def _keep(A, p, c, z):
    for i in range(7):
        store(A, (p, c + i), z[i])


@inlined
def _take(A, p, c, z, t, i, j):
    """Take what four pivots make of columns i and j."""
    taken = z[0][i] * t[0][j] + z[1][i] * t[1][j] + z[2][i] * t[2][j] + z[3][i] * t[3][j]
    store(A, (p, c), load(A, (p, c)) - taken)


@inlined
def eliminate(A, b, p, count, lowest):
    """Eliminate row p from the rows after it, in place; return the lowest pivots of this and before.

    A       (rows, 38, W), complete up to row p
    b       right-hand side (rows, 4, W)
    count   number of rows
    lowest  pivots of positions, and of angles
    """
    placed, turned = lowest
    d0, d01, d02, d03 = load(A, (p, 0)), load(A, (p, 1)), load(A, (p, 2)), load(A, (p, 3))
    d1, d12, d13 = load(A, (p, 11)), load(A, (p, 12)), load(A, (p, 13))
    d2, d23, d3 = load(A, (p, 21)), load(A, (p, 22)), load(A, (p, 30))
    t0, t1, t2, t3 = _seven(A, p, 4), _seven(A, p, 14), _seven(A, p, 23), _seven(A, p, 31)
    y0, y1, y2, y3 = load(b, (p, 0)), load(b, (p, 1)), load(b, (p, 2)), load(b, (p, 3))
    # Pivots one by one, not a block of four at a time: their signs show whether the matrix is positive definite.
    d0, placed = _pivot(d0, placed)
    i0 = 1.0 / d0
    w01 = d01 * i0
    w02 = d02 * i0
    w03 = d03 * i0
    z0 = _times(i0, t0)
    d1, placed = _pivot(d1 - w01 * d01, placed)
    i1 = 1.0 / d1
    d12 = d12 - w01 * d02
    d13 = d13 - w01 * d03
    t1 = _less(t1, w01, t0)
    y1 = y1 - w01 * y0
    w12 = d12 * i1
    w13 = d13 * i1
    z1 = _times(i1, t1)
    d2, placed = _pivot(d2 - w02 * d02 - w12 * d12, placed)
    i2 = 1.0 / d2
    d23 = d23 - w02 * d03 - w12 * d13
    t2 = _less(_less(t2, w02, t0), w12, t1)
    y2 = y2 - w02 * y0 - w12 * y1
    w23 = d23 * i2
    z2 = _times(i2, t2)
    d3, turned = _pivot(d3 - w03 * d03 - w13 * d13 - w23 * d23, turned)
    i3 = 1.0 / d3
    y3 = y3 - w03 * y0 - w13 * y1 - w23 * y2
    t3 = _less(_less(_less(t3, w03, t0), w13, t1), w23, t2)
    z3 = _times(i3, t3)
    # Divided by the pivots for `substitute`; the rows after this one take the undivided y.
    _store_four(b, p, (y0 * i0, y1 * i1, y2 * i2, y3 * i3))
    square = i0, w01, w02, w03, i1, w12, w13, i2, w23, i3
    for c in range(10):
        store(A, (p, _SQUARE[c]), square[c])
    _keep(A, p, 4, z0)
    _keep(A, p, 14, z1)
    _keep(A, p, 23, z2)
    _keep(A, p, 31, z3)
    z, t, y = (z0, z1, z2, z3), (t0, t1, t2, t3), (y0, y1, y2, y3)
    if p + 1 < count:
        _take_row(A, p + 1, z, t)
        for c in range(4):
            store(b, (p + 1, c), load(b, (p + 1, c)) - _taken(z, y, c))
    if p + 2 < count:
        _take_after(A, p + 2, z, t)
        for c in range(3):
            store(b, (p + 2, c), load(b, (p + 2, c)) - _taken(z, y, c + 4))
    return placed, turned


@inlined
def _taken(z, y, c):
    return z[0][c] * y[0] + z[1][c] * y[1] + z[2][c] * y[2] + z[3][c] * y[3]


@inlined
def _store_four(b, p, four):
    for c in range(UNKNOWNS):
        store(b, (p, c), four[c])


@inlined
def _take_row(A, p, z, t):
    """Take four pivots out of the row after them, all seven columns of it that they reach."""
    for j in range(7):
        _take(A, p, _X + j, z, t, 0, j)
    for j in range(1, 7):
        _take(A, p, _Y + j - 1, z, t, 1, j)
    for j in range(2, 7):
        _take(A, p, _Z + j - 2, z, t, 2, j)
    for j in range(3, 7):
        _take(A, p, _ANGLE + j - 3, z, t, 3, j)


@inlined
def _take_after(A, p, z, t):
    """Take four pivots out of the second row after them."""
    for j in range(3):
        _take(A, p, _X + j, z, t, 4, 4 + j)
    for j in range(1, 3):
        _take(A, p, _Y + j - 1, z, t, 5, 4 + j)
    _take(A, p, _Z, z, t, 6, 6)


@inlined
def forward(A, b, p, count):
    """Eliminate row p from another right-hand side, as `eliminate`, in place.

    A  factors, which may be kept in less precision than b
    """
    y0 = load(b, (p, 0))
    y1 = load(b, (p, 1)) - load_as(A, (p, 1), y0) * y0
    y2 = load(b, (p, 2)) - load_as(A, (p, 2), y0) * y0 - load_as(A, (p, 12), y0) * y1
    y3 = load(b, (p, 3)) - load_as(A, (p, 3), y0) * y0 - load_as(A, (p, 13), y0) * y1 - load_as(A, (p, 22), y0) * y2
    for c in range(7):  # Seven columns, of two rows: a row after the tip is left out.
        if p + 1 + c // 4 < count:
            place = p + 1 + c // 4, c % 4
            taken = load_as(A, (p, 4 + c), y0) * y0 + load_as(A, (p, 14 + c), y0) * y1
            taken = taken + load_as(A, (p, 23 + c), y0) * y2 + load_as(A, (p, 31 + c), y0) * y3
            store(b, place, load(b, place) - taken)
    inverses = load_as(A, (p, _X), y0), load_as(A, (p, _Y), y0), load_as(A, (p, _Z), y0), load_as(A, (p, _ANGLE), y0)
    _store_four(b, p, (inverses[0] * y0, inverses[1] * y1, inverses[2] * y2, inverses[3] * y3))


@inlined
def _reached(A, p, c, s):
    total = load_as(A, (p, c), s[0]) * s[0]
    for i in range(1, 7):
        total = total + load_as(A, (p, c + i), s[0]) * s[i]
    return total


@inlined
def substitute(A, b, count):
    """Replace b by the solution, in place, after every row has been eliminated; A may be kept in less precision."""
    zero = 0.0 * load(b, (0, 0))
    s = zero, zero, zero, zero, zero, zero, zero  # The seven unknowns after a row stay in registers from row to row.
    for p in range(count - 1, -1, -1):
        w = load(b, (p, 3)) - _reached(A, p, 31, s)
        z = load(b, (p, 2)) - load_as(A, (p, 22), w) * w - _reached(A, p, 23, s)
        y = load(b, (p, 1)) - load_as(A, (p, 12), w) * z - load_as(A, (p, 13), w) * w - _reached(A, p, 14, s)
        x = load(b, (p, 0)) - load_as(A, (p, 1), w) * y - load_as(A, (p, 2), w) * z - load_as(A, (p, 3), w) * w
        x = x - _reached(A, p, 4, s)
        _store_four(b, p, (x, y, z, w))
        s = x, y, z, w, s[0], s[1], s[2]
