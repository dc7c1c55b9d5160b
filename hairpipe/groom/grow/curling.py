"""Curls: a helix wound around the axis of a strand."""

import numpy as np
from numba import njit

from hairpipe.groom.resampling import put
from hairpipe.kernels.vec3 import Vector, cross, flattened, minus, plus, row, scaled, unit


@njit(cache=True)
def any_normal(direction: Vector) -> Vector:
    """Return some unit vector across a direction."""
    axis = (1.0, 0.0, 0.0) if abs(direction[0]) < 0.7 else (0.0, 1.0, 0.0)
    return unit(flattened(axis, direction), axis)


@njit(cache=True)
def wind(axis: np.ndarray, step: float, radius: float, pitch: float, onset: float, phase: float) -> None:
    """Wind a polyline (k, 3) with a point every step [m] into a helix around itself, in place.

    x(s) = a(s) + R(s) (cos(phi) n + sin(phi) b), phi = 2 pi s / pitch + phase, R(s) growing smoothly over onset [m]
    from 0 to radius [m]; n and b are transported along the axis without twist.
    """
    last = len(axis) - 1
    normal = (0.0, 0.0, 0.0)
    before = row(axis, 0)
    for k in range(last + 1):
        here = row(axis, k)
        ahead = row(axis, k + 1) if k < last else plus(here, minus(here, before))
        tangent = unit(minus(ahead, before), (0.0, -1.0, 0.0))
        before = here  # The old place of the point before, which has been moved: tangents are those of the axis.
        normal = unit(flattened(normal, tangent), any_normal(tangent))
        t = min(k * step / onset, 1.0)
        angle = 2.0 * np.pi * k * step / pitch + phase
        reach = radius * t * t * (3.0 - 2.0 * t)
        around = plus(scaled(np.cos(angle), normal), scaled(np.sin(angle), cross(tangent, normal)))
        put(axis, k, plus(here, scaled(reach, around)))
