"""Whether the cubic of two moving segments keeps its sign, eight pairs at once: most pairs are done with that.

The Bernstein coefficients of `sim/contact/ccd/coplanarity.py`, by the same formulas.
"""

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import WIDTH, bits, either, load, maximum, minimum, sqrt
from hairpipe.sim.contact.ccd.coplanarity import ROUNDING

ROWS = 18


@inlined
def may_cross(before, after, pairs, start, room):
    """Return which of the pairs from `start` on may have a root, as bits of an int64, eight of them or to the end.

    room  to compute in, (ROWS, WIDTH) float64
    """
    count = min(len(pairs) - start, WIDTH)
    for lane in range(WIDTH):
        i, j = pairs[start + min(lane, count - 1), 0], pairs[start + min(lane, count - 1), 1]
        for x in range(3):
            room[x, lane] = before[i + 1, x] - before[i, x]
            room[3 + x, lane] = after[i + 1, x] - after[i, x]
            room[6 + x, lane] = before[j + 1, x] - before[j, x]
            room[9 + x, lane] = after[j + 1, x] - after[j, x]
            room[12 + x, lane] = before[j, x] - before[i, x]
            room[15 + x, lane] = after[j, x] - after[i, x]
    A0, A1, C0, C1, P0, P1 = (
        _row(room, 0),
        _row(room, 3),
        _row(room, 6),
        _row(room, 9),
        _row(room, 12),
        _row(room, 15),
    )
    N0, N1, X, Y = _cross(A0, C0), _cross(A1, C1), _cross(A0, C1), _cross(A1, C0)
    N01 = (X[0] + Y[0], X[1] + Y[1], X[2] + Y[2])
    b0, b3 = _dot(N0, P0), _dot(N1, P1)
    b1, b2 = (_dot(N01, P0) + _dot(N0, P1)) / 3.0, (_dot(N01, P1) + _dot(N1, P0)) / 3.0
    sizes = maximum(_dot(A0, A0), _dot(A1, A1)) * maximum(_dot(C0, C0), _dot(C1, C1))
    noise = ROUNDING * sqrt(sizes * maximum(_dot(P0, P0), _dot(P1, P1)))
    low, high = minimum(minimum(b0, b1), minimum(b2, b3)), maximum(maximum(b0, b1), maximum(b2, b3))
    return ((1 << count) - 1) & ~bits(either(low > noise, high < -noise))


@inlined
def _row(room, r):
    return load(room, (r,)), load(room, (r + 1,)), load(room, (r + 2,))


@inlined
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
