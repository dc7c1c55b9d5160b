"""The points of two segments that are closest to each other, and distances between segments, sixteen at once (SIMD).

A leaf of segments is an array of rows, each of sixteen lanes, in units of a frame: x y z of the start p; x y z of the
vector d to the end; d.d; 1 / d.d, or 0; a bound on the error of distances that comes from the rounding of coordinates.
Segments that move are stored as they are at half time, and have six more rows: x y z of the displacements of the start
and of the end in half a step. A coordinate is rounded by ULP times itself; d.d is inf where |d|^4 is not finite.
"""

import numpy as np

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import both, load, maximum, minimum, multiply_add, sqrt
from hairpipe.geometry.vec3 import Vector, cross, dot, length, minus, plus, row, scaled

PARALLEL = 1e-13
"""Sine of the angle below which two segments count as parallel: what rounding makes of exactly parallel ones."""


@inlined
def closest_on_segments(
    a: Vector, b: Vector, c: Vector, d: Vector, parallel: float = PARALLEL
) -> tuple[float, float, float]:
    """Return fractions s of segment a b and t of segment c d where they are closest, and the squared distance [m^2].

    parallel  sine of the angle between them below which they count as parallel

    With u = b - a, v = d - c, w = a - c, n = u x v the lines are closest at s = -(w x v).n / n.n; s is clamped to 0..1,
    t is the closest to that, and where t has to be clamped, s is the closest to t: Ericson, Real-Time Collision
    Detection (2005), 5.1.9. The products with n lose nothing between nearly parallel segments, where his lose all.
    Of parallel segments that overlap the middle of the overlap is taken; a segment without length is closest at s = 0.
    """
    u, v, w = minus(b, a), minus(d, c), minus(a, c)
    uu, vv, uv, uw = dot(u, u), dot(v, v), dot(u, v), dot(u, w)
    n = cross(u, v)
    nn = dot(n, n)
    if nn > parallel * parallel * uu * vv:
        s = within(-dot(cross(w, v), n) / nn)
    elif uu > 0.0:
        from_c = -uw / uu
        from_d = (uv - uw) / uu
        low = max(0.0, min(from_c, from_d))
        high = min(1.0, max(from_c, from_d))
        s = within(0.5 * (low + high))
    else:
        s = 0.0
    free = (uv * s + dot(v, w)) / vv if vv > 0.0 else 0.0
    t = within(free)
    if t != free:  # Only where t was clamped is s not the best any more.
        s = within((uv * t - uw) / uu) if uu > 0.0 else 0.0
    gap = minus(plus(w, scaled(s, u)), scaled(t, v))
    return s, t, dot(gap, gap)


@inlined
def closest_of(points: np.ndarray, i: int, j: int) -> tuple[float, float, float]:
    """Return fractions of segments i and j where they are closest, and the squared distance [m^2].

    points  [m], (P, 3); segment i joins points i and i + 1
    """
    return closest_on_segments(row(points, i), row(points, i + 1), row(points, j), row(points, j + 1))


@inlined
def within(fraction: float) -> float:
    """Clamp to 0..1."""
    return min(max(fraction, 0.0), 1.0)


ULP = 2.0**-24
RESTING, MOVING = 9, 15
"""Rows of a leaf."""
_SQUARE, _INVERSE, _BLUR, _DRIFT = 6, 7, 8, 9
_TINY = 1e-30
_LONGEST = 1e8
_BLURRED = 512.0 * ULP
_ASKEW = 1024.0 * ULP


@inlined
def enter_segment(rows: np.ndarray, leaf: int, lane: int, p: Vector, q: Vector) -> None:
    """Write a segment from p to q to the rows of a leaf, in place."""
    d = minus(q, p)
    square = np.float32(dot(d, d))
    for x in range(3):
        rows[leaf, x, lane] = p[x]
        rows[leaf, 3 + x, lane] = d[x]
    rows[leaf, _SQUARE, lane] = square if square < _LONGEST * _LONGEST else np.inf
    rows[leaf, _INVERSE, lane] = 1.0 / square if square > 0.0 else 0.0
    rows[leaf, _BLUR, lane] = 8.0 * ULP * (_largest(p) + length(d) + 1.0)


@inlined
def enter_drift(rows: np.ndarray, leaf: int, lane: int, u: Vector, v: Vector) -> None:
    """Write the displacements u and v of its ends in half a step, in place."""
    for x in range(3):
        rows[leaf, _DRIFT + x, lane] = u[x]
        rows[leaf, _DRIFT + 3 + x, lane] = v[x]
    rows[leaf, _BLUR, lane] += 16.0 * ULP * (_largest(u) + _largest(v))


@inlined
def _largest(x: Vector) -> float:
    return max(abs(x[0]), max(abs(x[1]), abs(x[2])))


@inlined
def blur_of(rows: np.ndarray, leaf: int, lane: int) -> float:
    """Return the error bound of distances to a segment, without that of `farthest`."""
    return rows[leaf, _BLUR, lane]


@inlined
def shortest_ways(rows, leaf, few, mine, lane):
    """Return the shortest ways from the segments of a leaf to one in the rows of another, few, x y z as lanes.

    As `closest_on_segments`, but s of the lines is (b f - c e) / (a e - b^2). With u the rounding of single precision
    and theta the angle of the two, s is uncertain by du = (28 R / |d| + 14) u / sin^2 theta, R the distance of their
    starts; t and then s are the best for what was before, so that its square comes out too large by at most
    a sin^2 theta min(du, 1)^2 or u (28 R |d| + 14 a), whatever the angle.
    """
    d = _one(few, mine, 3, lane)
    dd = few[mine, _SQUARE, lane]
    inverse = few[mine, _INVERSE, lane]
    e = _all(rows, leaf, 3)
    ee = load(rows, (leaf, _SQUARE))
    over = load(rows, (leaf, _INVERSE))
    r = minus(_one(few, mine, 0, lane), _all(rows, leaf, 0))
    de, dr, er = _dot(d, e), _dot(d, r), _dot(e, r)
    area = maximum(multiply_add(dd, ee, -(de * de)), _TINY)  # Parallel: any s will do; t and s follow.
    # Three clamps in place of branches on sides and corners, which would diverge between lanes.
    s = minimum(maximum((de * er - dr * ee) / area, 0.0), 1.0)
    t = minimum(maximum(multiply_add(de, s, er) * over, 0.0), 1.0)
    s = minimum(maximum(multiply_add(de, t, -dr) * inverse, 0.0), 1.0)
    return (
        multiply_add(s, d[0], multiply_add(-t, e[0], r[0])),
        multiply_add(s, d[1], multiply_add(-t, e[1], r[1])),
        multiply_add(s, d[2], multiply_add(-t, e[2], r[2])),
    )


@inlined
def farthest(rows, leaf, few, mine, lane, distance):
    """Return the largest computed squares of segments of a leaf within a distance of one in other rows, as lanes.

    distance  with what `blur_of` the one is, a number or lanes

    The other coordinates are as large, but for the distance R and the lengths of both; for them, and for the arithmetic
    of squares, which has an error of less than 128 ULP (R + |d| + |e|)^2, there is 512 ULP (R^2 + d.d + e.e).
    """
    lengths = (load(rows, (leaf, _SQUARE)) + few[mine, _SQUARE, lane]) * _BLURRED  # May pass more pairs, never fewer.
    return distance * distance * np.float32(1.0 + _BLURRED) + lengths


@inlined
def fastest_squared(rows, leaf, few, mine, lane):
    """Return the largest squared displacement of an end relative to an end of one in the rows of another, as lanes."""
    u = _one(few, mine, _DRIFT, lane)
    v = _one(few, mine, _DRIFT + 3, lane)
    a = _all(rows, leaf, _DRIFT)
    b = _all(rows, leaf, _DRIFT + 3)
    first = maximum(length_squared(minus(u, a)), length_squared(minus(u, b)))
    second = maximum(length_squared(minus(v, a)), length_squared(minus(v, b)))
    return maximum(first, second)


@inlined
def kept_apart(rows, leaf, few, mine, lane, way, distance, drift):
    """Return which segments of a leaf stay farther than a distance from one in other rows during the step, as lanes.

    way       between them at half time, of `shortest_ways`
    distance  with what `blur_of` the one is
    drift     the largest relative displacement, root of `fastest_squared`, as lanes

    The test uses their gap along the way, the least of one minus the most of the other: it is concave in time, and so
    least at the start or at the end. The test is sufficient, not necessary. The arithmetic has an error of less than 64
    ULP |way| (R + |d| + |e| + drift); for that there is 1024 ULP |way| (|way| + 2 sqrt(d.d + e.e) + drift).
    """
    x = _dot(way, minus(_one(few, mine, 0, lane), _all(rows, leaf, 0)))
    nd = _dot(way, _one(few, mine, 3, lane))
    ne = _dot(way, _all(rows, leaf, 3))
    u = _one(few, mine, _DRIFT, lane)
    v = _one(few, mine, _DRIFT + 3, lane)
    a = _all(rows, leaf, _DRIFT)
    b = _all(rows, leaf, _DRIFT + 3)
    ua, ub, va, vb = _dot(way, minus(u, a)), _dot(way, minus(u, b)), _dot(way, minus(v, a)), _dot(way, minus(v, b))
    gaps = (x, ua), (x - ne, ub), (x + nd, va), (x + nd - ne, vb)
    least = minimum(gaps[0][0] - gaps[0][1], gaps[0][0] + gaps[0][1])
    for gap, change in gaps[1:]:
        least = minimum(least, minimum(gap - change, gap + change))
    lengths = load(rows, (leaf, _SQUARE)) + few[mine, _SQUARE, lane]
    size = sqrt(length_squared(way))
    least = least - _ASKEW * size * (size + 2.0 * sqrt(lengths) + drift)  # Less a bound on rounding.
    return both(least > distance * size, lengths < _LONGEST)


@inlined
def _one(rows, leaf, first, lane):
    return rows[leaf, first, lane], rows[leaf, first + 1, lane], rows[leaf, first + 2, lane]


@inlined
def _all(rows, leaf, first):
    return load(rows, (leaf, first)), load(rows, (leaf, first + 1)), load(rows, (leaf, first + 2))


@inlined
def _dot(a, b):
    return multiply_add(a[0], b[0], multiply_add(a[1], b[1], a[2] * b[2]))


@inlined
def length_squared(a):
    """Return |a|^2 of a vector of lanes."""
    return _dot(a, a)
