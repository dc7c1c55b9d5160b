"""Two segments that move linearly through a step."""

from typing import NamedTuple

import numpy as np

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, length, minus, mix, row
from hairpipe.spatial.segment_distance import closest_on_segments
from hairpipe.spatial.segments import TOUCHING

NEARLY_PARALLEL = 1e-6
"""Sine of an angle: what lies farther apart anywhere on the two for that is still touching."""


class Encounter(NamedTuple):
    """Segments a b and c d [m], at the start and at the end of a step."""

    a: tuple[Vector, Vector]
    b: tuple[Vector, Vector]
    c: tuple[Vector, Vector]
    d: tuple[Vector, Vector]


@inlined
def encounter(before: np.ndarray, after: np.ndarray, i: int, j: int) -> Encounter:
    """Give the motion of segments i and j between positions [m], (P, 3)."""
    return Encounter(
        (row(before, i), row(after, i)),
        (row(before, i + 1), row(after, i + 1)),
        (row(before, j), row(after, j)),
        (row(before, j + 1), row(after, j + 1)),
    )


@inlined
def meet(pair: Encounter, time: float) -> tuple[float, float, float]:
    """Return fractions of both segments where they are closest at a fraction of the step, and the squared distance.

    Of nearly parallel ones that is the middle of where they overlap.
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
