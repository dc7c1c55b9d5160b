"""Two segments that move linearly through a step: where they are closest, and how they are kept apart."""

from typing import NamedTuple

import numpy as np

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import (
    Vector,
    any_across,
    cross,
    dot,
    flattened,
    length,
    minus,
    mix,
    row,
    scaled,
    unit,
)
from hairpipe.spatial.segment_distance import closest_on_segments
from hairpipe.spatial.segments import TOUCHING

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
