"""The axis of a strand: it leaves the skin, bends over, slides along the body and hangs."""

import numpy as np
from numba import njit

from hairpipe.body.solid import Solid, distance_and_normal
from hairpipe.body.vectors import Vector, dot, flattened, length, minus, mix, plus, row, times, unit
from hairpipe.groom.resampling import put

DOWN = (0.0, -1.0, 0.0)
FADE = 0.01  # above the layer it lies in, over which a strand leaves the comb to gravity [m]
RISE = 0.03  # from the root, over which a strand rises to its layer, and clears the skin by the full gap [m]


@njit(cache=True)
def pull(comb: Vector, touch: float, normal: Vector) -> Vector:
    """Return the direction a strand is pulled: gravity, and where it touches the body the comb; never into the body."""
    direction = unit(plus(DOWN, times(touch, flattened(comb, normal))), DOWN)
    return minus(direction, times(touch * min(dot(direction, normal), 0.0), normal))


@njit(cache=True)
def lay(solid: Solid, axis: np.ndarray, ahead: Vector, comb: Vector, layer: float, bend: float, step: float) -> None:
    """Write a polyline (k, 3) with a point every step [m] from its first point, which is the root.

    ahead  unit direction in which it leaves the skin
    comb   pull where it touches the body, in units of gravity
    layer  distance from the body at which it slides along [m]
    bend   length over which it turns to where it is pulled [m]
    """
    here = row(axis, 0)
    gap, normal, place = distance_and_normal(solid, here, 0)
    need, free = 0.0, 0.0
    for k in range(1, len(axis)):
        touch = min(max(1.0 - (gap - need) / FADE, 0.0), 1.0)
        ahead = unit(mix(ahead, pull(comb, touch, normal), min(step / bend, 1.0)), ahead)
        there = plus(here, times(step, ahead))
        need = layer * (1.0 - np.exp(-k * step / RISE))
        free -= step
        if free <= 0.0:
            gap, normal, place = distance_and_normal(solid, there, place)
            free = gap - layer - FADE
        if gap < need:
            ahead = unit(minus(plus(there, times(need - gap, normal)), here), ahead)
            there, gap = plus(here, times(step, ahead)), need
        put(axis, k, there)
        here = there


@njit(cache=True)
def lift_off(solid: Solid, curve: np.ndarray, gap: float) -> None:
    """Move the points of a polyline (k, 3) out of the body, in place, to clear it by a gap that grows to gap [m]."""
    free, way, place = 0.0, 0.0, 0
    before = row(curve, 0)
    for k in range(1, len(curve)):
        here = row(curve, k)
        step = length(minus(here, before))
        free, way, before = free - step, way + step, here
        if free <= 0.0:
            d, normal, place = distance_and_normal(solid, here, place)
            free = d - gap
            need = gap * min(way / RISE, 1.0)
            if d < need:
                put(curve, k, plus(here, times(need - d, normal)))
