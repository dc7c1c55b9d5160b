"""The direction in which two segments that met must be kept apart."""

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, any_across, cross, dot, flattened, length, minus, mix, scaled, unit
from hairpipe.sim.contact.ccd.moving_segments import Encounter

_PARALLEL = 1e-8
"""Sine of the angle below which the normal of the plane of both is rounding."""


@inlined
def crossing_normal(pair: Encounter, time: float, s: float, t: float) -> Vector:
    """Return the unit normal against which the first segment's point approaches the second's.

    s, t  fractions of the segments where they meet, at a fraction of the step

    The normal of both; of parallel ones the direction of approach, across them. Where they meet without approaching it
    is some direction across the first.
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
