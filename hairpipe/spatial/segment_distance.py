"""The points of two segments that are closest to each other."""

import numpy as np

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, cross, dot, minus, plus, row, scaled

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
