"""Pairs of segments that pass through each other in a step, with place and time: Sec. 5.3, edge against edge.

Two segments that move linearly through a step: where they are closest, and how they are kept apart.

First time at which two moving segments are coplanar and meet: the roots of a cubic.

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

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.segment_distance import closest_on_segments
from hairpipe.geometry.segments import TOUCHING, key_of
from hairpipe.geometry.simd import WIDTH, bits, either, load, lowest, maximum, minimum, sqrt
from hairpipe.geometry.sorting import places_of
from hairpipe.geometry.vec3 import (
    Vector,
    any_across,
    cross,
    dot,
    flattened,
    length,
    minus,
    mix,
    plus,
    row,
    scaled,
    unit,
)

NEARLY_PARALLEL = 1e-6
"""Sine of an angle: what lies farther apart anywhere on the two for that is still touching."""
_PARALLEL = 1e-8
"""Sine of the angle below which the normal of the plane of both is rounding."""


class Encounter(NamedTuple):
    """Segments a b and c d [m], at the start and at the end of a step."""

    a: tuple[Vector, Vector]
    b: tuple[Vector, Vector]
    c: tuple[Vector, Vector]
    d: tuple[Vector, Vector]


@inlined
def encounter(before: np.ndarray, after: np.ndarray, i: int, j: int) -> Encounter:
    """Return the motion of segments i and j between positions [m], (P, 3)."""
    return Encounter(
        (row(before, i), row(after, i)),
        (row(before, i + 1), row(after, i + 1)),
        (row(before, j), row(after, j)),
        (row(before, j + 1), row(after, j + 1)),
    )


@inlined
def meet(pair: Encounter, time: float) -> tuple[float, float, float]:
    """Return fractions of both segments where they are closest at a fraction of the step, and the squared distance.

    For nearly parallel segments this is the middle of the overlap.
    """
    a, b = mix(pair.a[0], pair.a[1], time), mix(pair.b[0], pair.b[1], time)
    c, d = mix(pair.c[0], pair.c[1], time), mix(pair.d[0], pair.d[1], time)
    return closest_on_segments(a, b, c, d, NEARLY_PARALLEL)


@inlined
def lengths(pair: Encounter) -> float:
    """Return the sum of both segments' lengths [m], each where it is longer."""
    first = max(length(minus(pair.b[0], pair.a[0])), length(minus(pair.b[1], pair.a[1])))
    second = max(length(minus(pair.d[0], pair.c[0])), length(minus(pair.d[1], pair.c[1])))
    return first + second


@inlined
def touch_inside(pair: Encounter, time: float) -> bool:
    """Whether the segments touch at a fraction of the step, neither with an end."""
    s, t, squared = meet(pair, time)
    return 0.0 < s < 1.0 and 0.0 < t < 1.0 and squared <= (TOUCHING * lengths(pair)) ** 2


@inlined
def crossing_normal(pair: Encounter, time: float, s: float, t: float) -> Vector:
    """Return the unit normal against which the first segment's point approaches the second's.

    s, t  fractions of the segments where they meet, at a fraction of the step

    The common normal; for parallel segments the direction of approach, normal to them. Without an approach it is an
    arbitrary normal of the first.
    """
    A = minus(mix(pair.b[0], pair.b[1], time), mix(pair.a[0], pair.a[1], time))
    C = minus(mix(pair.d[0], pair.d[1], time), mix(pair.c[0], pair.c[1], time))
    first = mix(minus(pair.a[1], pair.a[0]), minus(pair.b[1], pair.b[0]), s)
    second = mix(minus(pair.c[1], pair.c[0]), minus(pair.d[1], pair.d[0]), t)
    approach = minus(second, first)
    normal = cross(A, C)
    if length(normal) <= _PARALLEL * length(A) * length(C):
        along = A if dot(A, A) >= dot(C, C) else C
        normal = flattened(approach, unit(along, (0.0, 0.0, 0.0)))
        if length(normal) <= _PARALLEL * length(approach) or length(normal) == 0.0:
            normal = any_across(along)
    normal = unit(normal, (0.0, 0.0, 1.0))
    return normal if dot(normal, approach) >= 0.0 else scaled(-1.0, normal)


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
    """Return which of the pairs from `start` on may have a root, as bits of an int64, eight of them or to the end."""
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


_CHUNK = 1024


class Crossings(NamedTuple):
    """The first crossing of each pair of crossing segments.

    segments   first < second, rows in lexicographic order, (n, 2) int32
    fractions  positions of the crossing on both segments, (n, 2) float64
    times      time of the crossing, a fraction of the step, (n,) float64
    normals    normal to both, from the second to the first before the crossing, (n, 3) float64
    """

    segments: np.ndarray
    fractions: np.ndarray
    times: np.ndarray
    normals: np.ndarray


def crossings(before: np.ndarray, after: np.ndarray, pairs: np.ndarray) -> Crossings:
    """Find the pairs of segments that pass through or touch each other in a linear motion; pure.

    before, after  positions [m], (P, 3) float64
    pairs          candidates, see `swept_pairs`, (n, 2) int32

    Bridson et al. 2002, edges alone: segments that meet at an end point are left out, unless an edge passes exactly
    through a joint.
    """
    times = np.empty(len(pairs))
    meet = np.empty(len(pairs), np.bool_)
    _find_times(before, after, pairs, times, meet)
    found = places_of(meet)
    found = found[np.argsort(key_of(pairs[found]), kind="stable")]
    times, segments = times[found], pairs[found]
    fractions, normals = np.empty((len(found), 2)), np.empty((len(found), 3))
    _describe(before, after, segments, times, fractions, normals)
    return Crossings(segments, fractions, times, normals)


@njit(cache=True, parallel=True)
def _find_times(before, after, pairs, times, meet):
    """Mark the pairs that meet, and write when, in place."""
    for chunk in prange(-(-len(pairs) // _CHUNK)):
        room = np.empty((ROWS, WIDTH))
        for start in range(np.int64(chunk) * _CHUNK, min((np.int64(chunk) + 1) * _CHUNK, len(pairs)), WIDTH):
            meet[start : start + WIDTH] = False
            # Signs of eight cubics at once; most pairs end here, and the rest are solved one by one.
            possible = may_cross(before, after, pairs, start, room)
            while possible != 0:
                k = start + lowest(possible)
                possible &= possible - 1
                times[k] = coplanar_time(encounter(before, after, pairs[k, 0], pairs[k, 1]))
                meet[k] = times[k] <= 1.0


@njit(cache=True, parallel=True)
def _describe(before, after, segments, times, fractions, normals):
    for k in prange(len(segments)):
        pair = encounter(before, after, segments[k, 0], segments[k, 1])
        fractions[k, 0], fractions[k, 1], _ = meet(pair, times[k])
        normal = crossing_normal(pair, times[k], fractions[k, 0], fractions[k, 1])
        normals[k, 0], normals[k, 1], normals[k, 2] = normal
