"""When two moving segments first lie in one plane and meet there: the roots of a cubic.

With A, C the segments and P from the start of the first to that of the second, all linear in the time t of 0..1,
f(t) = (A x C) . P = 0, Bridson et al. 2002 Sec. 6. As a product of linear functions it has the Bernstein coefficients

    b0 = N0.P0,  b1 = (N01.P0 + N0.P1) / 3,  b2 = (N01.P1 + N1.P0) / 3,  b3 = N1.P1,   N01 = A0 x C1 + A1 x C0

of which no difference is taken; where all have one sign there is no root. Between its extremes f is monotone.
"""

import numpy as np
from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, cross, dot, length, minus, mix, plus
from hairpipe.sim.contact.ccd.grazing import first_graze, quadratic_roots
from hairpipe.sim.contact.ccd.moving_segments import NEARLY_PARALLEL, Encounter, lengths, meet, touch_inside
from hairpipe.spatial.segments import TOUCHING

Cubic = tuple[float, float, float, float]
ROUNDING = 32 * 2.0**-52
_LOOSEST = 1e-4
"""Distance over the lengths of both segments at a root that rounding blurs."""
_EXACTLY = 1e-9
"""Distance over the lengths of both segments at which an end is on the other segment."""


@inlined
def coplanar_time(pair: Encounter) -> float:
    """Return the fraction of the step at which two segments first meet, inf if they do not."""
    A0, A1, C0, C1 = _sides(pair)
    P0, P1 = minus(pair.c[0], pair.a[0]), minus(pair.c[1], pair.a[1])
    N0, N1, N01 = cross(A0, C0), cross(A1, C1), plus(cross(A0, C1), cross(A1, C0))
    b = (dot(N0, P0), (dot(N01, P0) + dot(N0, P1)) / 3.0, (dot(N01, P1) + dot(N1, P0)) / 3.0, dot(N1, P1))
    area = max(length(A0), length(A1)) * max(length(C0), length(C1))
    noise = ROUNDING * area * max(length(P0), length(P1))
    if min(min(b[0], b[1]), min(b[2], b[3])) > noise or max(max(b[0], b[1]), max(b[2], b[3])) < -noise:
        return np.inf
    time = _first_root(pair, b, noise)
    if max(length(N0), max(length(N1), 0.5 * length(N01))) <= NEARLY_PARALLEL * area or _is_flat(b, noise):
        time = min(time, first_graze(pair))
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
    left, f_left = 0.0, b[0]
    for right in (low, high, 1.0):
        f_right = _value(b, right)
        if abs(f_left) <= noise and touch_inside(pair, left):
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
    negative_left = _value(b, low) < 0.0
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
    Lines that are nearly parallel are as far apart as rounding leaves them at the root.
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
