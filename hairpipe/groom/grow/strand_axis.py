"""The axis of a strand: it leaves the skin, bends over, slides along the body and hangs."""

import numpy as np
from numba import njit

from hairpipe.body.solid import Solid, distance_and_normal
from hairpipe.groom.resampling import put
from hairpipe.kernels.vec3 import Vector, dot, flattened, length, minus, mix, plus, row, scaled, unit

DOWN = (0.0, -1.0, 0.0)
FADE = 0.01  # above the layer it lies in, over which a strand leaves the comb to gravity [m]
LEAST = 0.5  # of the gap, that is enough where segments cut corners
PUSHES, WAYS = 8, 200  # attempts to turn a segment out of the body, and directions tried where all fail
GOLDEN = np.pi * (3.0 - np.sqrt(5.0))  # angle that spreads directions evenly over the sphere [rad]
TOUCHED = 1e-7  # that may lack of the gap [m]
RISE = 0.03  # from the root, over which a strand rises to its layer, and clears the skin by the full gap [m]


@njit(cache=True)
def pull(comb: Vector, touch: float, normal: Vector) -> Vector:
    """Return the direction a strand is pulled: gravity, and where it touches the body the comb; never into the body."""
    direction = unit(plus(DOWN, scaled(touch, flattened(comb, normal))), DOWN)
    return minus(direction, scaled(touch * min(dot(direction, normal), 0.0), normal))


@njit(cache=True)
def lay(solid: Solid, axis: np.ndarray, ahead: Vector, comb: Vector, layer: float, bend: float, step: float) -> None:
    """Write a polyline (k, 3) with a point every step [m] from its first point, which is the root.

    ahead  unit direction at the skin
    comb   pull where it touches the body, in units of gravity
    layer  distance from the body at which it slides [m]
    bend   length over which it bends to the direction of its pull [m]
    """
    here = row(axis, 0)
    gap, normal, place = distance_and_normal(solid, here, 0)
    need, free = 0.0, 0.0
    for k in range(1, len(axis)):
        touch = min(max(1.0 - (gap - need) / FADE, 0.0), 1.0)  # The comb acts on hair that lies on the body only.
        ahead = unit(mix(ahead, pull(comb, touch, normal), min(step / bend, 1.0)), ahead)
        there = plus(here, scaled(step, ahead))
        need = layer * (1.0 - np.exp(-k * step / RISE))
        free -= step
        if free <= 0.0:  # The distance bounds how far the strand goes before it can meet the body: no look until then.
            gap, normal, place = distance_and_normal(solid, there, place)
            free = gap - layer - FADE
        if gap < need:
            ahead = unit(minus(plus(there, scaled(need - gap, normal)), here), ahead)
            there = plus(here, scaled(step, ahead))
            gap = need
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
        free = free - step
        way = way + step
        before = here
        if free <= 0.0:
            d, normal, place = distance_and_normal(solid, here, place)
            free = d - gap
            need = gap * min(way / RISE, 1.0)
            if d < need:
                put(curve, k, plus(here, scaled(need - d, normal)))


@njit(cache=True)
def clearance(solid: Solid, here: Vector, there: Vector, need: float, place: int) -> tuple[float, float, Vector, int]:
    """Return the distance of a segment's end from the body [m], its deficit [m] and the direction of correction.

    need   required distance of its end from the body [m]; its middle should be outside
    place  guess of the closest triangle

    The third value is the outward direction in which the end has to move by the deficit; the last the closest triangle.
    """
    gap, normal, place = distance_and_normal(solid, there, place)
    lack = need - gap
    if gap < length(minus(there, here)):
        inside, across, _ = distance_and_normal(solid, mix(here, there, 0.5), place)
        if -2.0 * inside > lack:
            lack = -2.0 * inside
            normal = across
    return gap, lack, normal, place


@njit(cache=True)
def turned_out(solid: Solid, here: Vector, there: Vector, need: float, place: int) -> Vector:
    """Return the end of a segment rotated about its root, which is outside, until it is clear of the body.

    The deficit is added and the length restored, iteratively. If that fails, as between two walls, it takes the
    direction nearest to its own among many with enough clearance; otherwise that with the largest clearance.
    """
    way = length(minus(there, here))
    end = there
    for _ in range(PUSHES):
        _, lack, normal, place = clearance(solid, here, end, need, place)
        if lack <= TOUCHED:
            return end
        end = plus(here, scaled(way, unit(minus(plus(end, scaled(lack, normal)), here), normal)))
    best = end
    least = np.inf
    nearest = -np.inf
    for i in range(WAYS):  # A spiral over the sphere: directions are spread evenly, and the same for every strand.
        height = 1.0 - (2.0 * i + 1.0) / WAYS
        turn = i * GOLDEN
        across = np.sqrt(1.0 - height * height)
        aside = (across * np.cos(turn), height, across * np.sin(turn))
        end = plus(here, scaled(way, aside))
        _, lack, _, _ = clearance(solid, here, end, LEAST * need, place)
        along = dot(aside, minus(there, here)) if lack <= 0.0 else -np.inf
        if along > nearest or (nearest == -np.inf and lack < least):
            best, least, nearest = end, lack, along
    return best


@njit(cache=True)
def keep_out(solid: Solid, points: np.ndarray, gap: float) -> None:
    """Rotate segments out of the body, in place, from the root on; lengths are unchanged.

    points  points of a strand, the first on the skin [m], (k, 3)
    gap     required clearance of points, from RISE on [m]; only those with less than LEAST of it are moved

    The strand beyond a segment is translated with its end, so that its shape is kept: a curl stays a curl.
    """
    free, way, place = 0.0, 0.0, 0
    for k in range(1, len(points)):
        here = row(points, k - 1)
        there = row(points, k)
        step = length(minus(there, here))
        free = free - step
        way = way + step
        if free > 0.0:
            continue
        need = gap * min(way / RISE, 1.0)
        d, lack, _, place = clearance(solid, here, there, LEAST * need, place)
        if lack > 0.0:
            clear = turned_out(solid, here, there, need, place)
            shift = minus(clear, there)
            for j in range(k, len(points)):  # The rest goes along, so that its shape stays.
                put(points, j, plus(row(points, j), shift))
            d, _, place = distance_and_normal(solid, clear, place)
        free = d - gap
