"""When two segments first meet that lie in one plane all the time, or are nearly parallel: an end comes to a line.

The cubic of `coplanarity.py` says nothing then. With E from the start of a segment A to an end of the other,
E x A = 0, a quadratic in time: where its largest component is zero.
"""

import numpy as np
from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, cross, minus, plus
from hairpipe.sim.contact.ccd.moving_segments import Encounter, touch_inside

Path = tuple[Vector, Vector]


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
    q0, q1, q2 = cross(E0, A0), plus(cross(E0, A1), cross(E1, A0)), cross(E1, A1)
    largest, times = -1.0, (1.0, 1.0)
    for first, doubled, last in zip(q0, q1, q2):  # noqa: B905, numba has no strict
        size = max(abs(first), abs(0.5 * doubled), abs(last))
        if size > largest:
            largest, times = size, quadratic_roots(first, 0.5 * doubled, last)
    return times


@inlined
def quadratic_roots(first: float, middle: float, last: float) -> tuple[float, float]:
    """Return the roots of first u^2 + 2 middle u t + last t^2, u = 1 - t, in 0 < t < 1, in order, and 1 for others.

    Of one without roots that is twice where it comes closest to zero: rounding may have taken a double root away.
    """
    square, half = first - 2.0 * middle + last, middle - first
    q = -(half + np.copysign(np.sqrt(max(half * half - square * first, 0.0)), half))
    x = q / square if square != 0.0 else 1.0
    y = first / q if q != 0.0 else 1.0
    x, y = x if 0.0 < x < 1.0 else 1.0, y if 0.0 < y < 1.0 else 1.0
    return min(x, y), max(x, y)
