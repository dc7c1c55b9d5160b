"""First time at which two moving segments are coplanar and meet: the roots of a cubic.

With A, C the segments and P the vector from the start of the first to that of the second, all linear in the time t of
0..1,
f(t) = (A x C) . P = 0, Bridson et al. 2002 Sec. 6. As a product of linear functions it has the Bernstein coefficients

    b0 = N0.P0,  b1 = (N01.P0 + N0.P1) / 3,  b2 = (N01.P1 + N1.P0) / 3,  b3 = N1.P1,   N01 = A0 x C1 + A1 x C0

without differences of them; if all have one sign there is no root. `may_cross` tests this for eight pairs at once,
which excludes most pairs. Between its extremes f is monotone.

For segments that are coplanar at all times, or nearly parallel, the cubic is degenerate. These meet where an end
reaches the line of the other: with E from the start of a segment A to an end of the other, E x A = 0, a quadratic in
time, solved for its largest component.
"""

import numpy as np
from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import WIDTH, bits, either, load, maximum, minimum, sqrt
from hairpipe.kernels.vec3 import Vector, cross, dot, length, minus, mix, plus
from hairpipe.sim.contact.ccd.moving_segments import NEARLY_PARALLEL, Encounter, lengths, meet, touch_inside
from hairpipe.spatial.segments import TOUCHING

Cubic = tuple[float, float, float, float]
Path = tuple[Vector, Vector]
"""Of a point, from the start of the step to its end [m]."""
ROWS = 18
"""Rows of lanes that `may_cross` computes in."""
_ROUNDING = 32 * 2.0**-52
_LOOSEST = 1e-4
"""Distance over the lengths of both segments at a root that rounding blurs."""
_EXACTLY = 1e-9
"""Distance over the lengths of both segments at which an end is on the other segment."""


@inlined
def coplanar_time(pair: Encounter) -> float:
    """Return the fraction of the step at which two segments first meet, inf if they do not."""
    A0, A1, C0, C1 = _sides(pair)
    P0, P1 = minus(pair.c[0], pair.a[0]), minus(pair.c[1], pair.a[1])
    N0 = cross(A0, C0)
    N1 = cross(A1, C1)
    N01 = plus(cross(A0, C1), cross(A1, C0))
    b = (dot(N0, P0), (dot(N01, P0) + dot(N0, P1)) / 3.0, (dot(N01, P1) + dot(N1, P0)) / 3.0, dot(N1, P1))
    area = max(length(A0), length(A1)) * max(length(C0), length(C1))
    noise = _ROUNDING * area * max(length(P0), length(P1))
    # All Bernstein coefficients of one sign, beyond rounding: no root, as f is within their hull.
    if min(min(b[0], b[1]), min(b[2], b[3])) > noise or max(max(b[0], b[1]), max(b[2], b[3])) < -noise:
        return np.inf
    time = _first_root(pair, b, noise)
    if max(length(N0), max(length(N1), 0.5 * length(N01))) <= NEARLY_PARALLEL * area or _is_flat(b, noise):
        time = min(time, first_graze(pair))  # The cubic is noise here: an end has to come to the other line.
    return time


@inlined
def _sides(pair: Encounter) -> tuple[Vector, Vector, Vector, Vector]:
    return (
        minus(pair.b[0], pair.a[0]),
        minus(pair.b[1], pair.a[1]),
        minus(pair.d[0], pair.c[0]),
        minus(pair.d[1], pair.c[1]),
    )


@inlined
def _is_flat(b: Cubic, noise: float) -> bool:
    return max(max(abs(b[0]), abs(b[1])), max(abs(b[2]), abs(b[3]))) <= noise


@njit(cache=True)
def _first_root(pair: Encounter, b: Cubic, noise: float) -> float:
    """Return the first root at which the segments meet, inf if there is none."""
    low, high = quadratic_roots(b[1] - b[0], b[2] - b[1], b[3] - b[2])
    left = 0.0
    f_left = b[0]
    for right in (low, high, 1.0):  # Between its extremes the cubic is monotone: at most one root in each interval.
        f_right = _value(b, right)
        if abs(f_left) <= noise and touch_inside(pair, left):  # A double root touches zero without a change of sign.
            return left
        if (f_left < 0.0) != (f_right < 0.0):
            root = _bracketed(b, left, right)
            if _pass(pair, root, noise):
                return root
        left, f_left = right, f_right
    return 1.0 if abs(f_left) <= noise and touch_inside(pair, 1.0) else np.inf


@njit(cache=True)
def _value(b: Cubic, t: float) -> float:
    u = 1.0 - t
    return u * u * (u * b[0] + 3.0 * t * b[1]) + t * t * (3.0 * u * b[2] + t * b[3])


@njit(cache=True)
def _slope(b: Cubic, t: float) -> float:
    u = 1.0 - t
    return 3.0 * (u * u * (b[1] - b[0]) + 2.0 * u * t * (b[2] - b[1]) + t * t * (b[3] - b[2]))


@njit(cache=True)
def _bracketed(b: Cubic, low: float, high: float) -> float:
    """Return the root between low and high, where the cubic changes sign: Newton's method, kept in by bisection."""
    negative_left = _value(b, low) < 0.0  # The bracket is kept while Newton's method converges, which may leave it.
    t = 0.5 * (low + high)
    for _ in range(100):
        value = _value(b, t)
        if (value < 0.0) == negative_left:
            low = t
        else:
            high = t
        slope = _slope(b, t)
        following = t - value / slope if slope != 0.0 else np.inf
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if following == t or high - low <= 1e-16:
            break
        t = following
    return t


@njit(cache=True)
def _pass(pair: Encounter, time: float, noise: float) -> bool:
    """Whether the segments pass through each other at a root of odd order.

    A joint that passes exactly through an edge does so with both of its segments or, rounded, with none: an end counts.
    The distance of nearly parallel lines at the root is that of rounding.
    """
    s, t, squared = meet(pair, time)
    size = lengths(pair)
    allowed = _EXACTLY * size
    if 0.0 < s < 1.0 and 0.0 < t < 1.0:
        A0, A1, C0, C1 = _sides(pair)
        area = length(cross(mix(A0, A1, time), mix(C0, C1, time)))
        blur = noise / area if area > 0.0 else np.inf
        allowed = max(TOUCHING * size, min(blur, _LOOSEST * size))
    return squared <= allowed * allowed


@njit(cache=True)
def first_graze(pair: Encounter) -> float:
    """Return the first fraction of the step at which an end is on the other's line and they touch, else inf."""
    a, b, c, d = pair
    first = np.inf
    for end, start, stop in ((a, c, d), (b, c, d), (c, a, b), (d, a, b)):
        for time in _times_on_line(end, start, stop):
            if time < first and touch_inside(pair, time):
                first = time
    return first


@njit(cache=True)
def _times_on_line(end: Path, start: Path, stop: Path) -> tuple[float, float]:
    E0, E1 = minus(end[0], start[0]), minus(end[1], start[1])
    A0, A1 = minus(stop[0], start[0]), minus(stop[1], start[1])
    q0 = cross(E0, A0)
    q1 = plus(cross(E0, A1), cross(E1, A0))
    q2 = cross(E1, A1)
    largest = -1.0
    times = (1.0, 1.0)
    for first, doubled, last in zip(q0, q1, q2):  # noqa: B905, numba has no strict
        size = max(abs(first), abs(0.5 * doubled), abs(last))
        if size > largest:  # The other components may be nothing but rounding.
            largest = size
            times = quadratic_roots(first, 0.5 * doubled, last)
    return times


@inlined
def quadratic_roots(first: float, middle: float, last: float) -> tuple[float, float]:
    """Return the roots of first u^2 + 2 middle u t + last t^2, u = 1 - t, in 0 < t < 1, in order, and 1 for others.

    Without real roots, returns twice the minimum of its absolute value: rounding may have removed a double root.
    """
    square = first - 2.0 * middle + last
    half = middle - first
    # No difference of nearly equal numbers: one root is q / a, and the other c / q.
    q = -(half + np.copysign(np.sqrt(max(half * half - square * first, 0.0)), half))
    x = q / square if square != 0.0 else 1.0
    y = first / q if q != 0.0 else 1.0
    x, y = x if 0.0 < x < 1.0 else 1.0, y if 0.0 < y < 1.0 else 1.0
    return min(x, y), max(x, y)


@inlined
def may_cross(before, after, pairs, start, room):
    """Return which of the pairs from `start` on may have a root, as bits of an int64, eight of them or to the end.

    room  work array, (ROWS, WIDTH) float64
    """
    count = min(len(pairs) - start, WIDTH)
    for lane in range(WIDTH):
        # Lanes beyond the last pair repeat it; the mask at the end drops them.
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
    N0, N1, X, Y = cross(A0, C0), cross(A1, C1), cross(A0, C1), cross(A1, C0)
    N01 = (X[0] + Y[0], X[1] + Y[1], X[2] + Y[2])
    b0, b3 = dot(N0, P0), dot(N1, P1)
    b1, b2 = (dot(N01, P0) + dot(N0, P1)) / 3.0, (dot(N01, P1) + dot(N1, P0)) / 3.0
    sizes = maximum(dot(A0, A0), dot(A1, A1)) * maximum(dot(C0, C0), dot(C1, C1))
    noise = _ROUNDING * sqrt(sizes * maximum(dot(P0, P0), dot(P1, P1)))
    low = minimum(minimum(b0, b1), minimum(b2, b3))
    high = maximum(maximum(b0, b1), maximum(b2, b3))
    return ((1 << count) - 1) & ~bits(either(low > noise, high < -noise))


@inlined
def _row(room, r):
    return load(room, (r,)), load(room, (r + 1,)), load(room, (r + 2,))
