"""When points that move run into a body in parts: each part stands still in its own frame, where the points come by."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, length, minus, mix
from hairpipe.levelset.boxes import passage
from hairpipe.levelset.parts.field import PartField
from hairpipe.levelset.parts.pose_path import Stances
from hairpipe.levelset.parts.probe import nearest_part
from hairpipe.levelset.parts.shape import place_in, shape_change, shape_distance

CHUNK = 512
"""Points that a thread takes at a time."""
# How much steeper than 1 what is read may be, between samples.
MARGIN = 1.25
# Of the spacing of samples: how far a point moves at least from look to look, and how well a meeting is known.
LEAST, SHARP = 1e-2, 1e-5
# [m]; a way as short as this is no way.
STILL = 1e-12


class Shape(NamedTuple):
    """What the distance to a part is read from: `shape_distance`'s first four arguments."""

    before: PartField
    after: PartField
    changes: np.ndarray
    part: int


class Leg(NamedTuple):
    """A straight way in the frame of a part.

    start, end  [m]
    a, b        when it begins and ends, since the first frame [frames]
    """

    start: Vector
    end: Vector
    a: float
    b: float


@inlined
def distance_on(shape: Shape, leg: Leg, s: float) -> float:
    """Return the distance [m] to a part at a fraction s of a leg."""
    a = leg.a + s * (leg.b - leg.a)
    return shape_distance(shape.before, shape.after, shape.changes, shape.part, a, mix(leg.start, leg.end, s))


@inlined
def change_along(shape: Shape, leg: Leg, s: float) -> float:
    """Return how much the part's change of shape changes the distance over a leg, as it is at its fraction s [m]."""
    change = shape_change(shape.before, shape.after, shape.changes, shape.part, mix(leg.start, leg.end, s))
    return abs(change) * (leg.b - leg.a)


@inlined
def meeting(shape: Shape, leg: Leg, low: Vector, high: Vector, kept: float) -> float:
    """Return the fraction of a leg at which the distance gets below `kept` [m], or inf.

    low, high  corners of the part's box [m]

    Sphere tracing (Hart 1996): the distance tells how far on the part cannot be. Along a way over which it changes by
    at most L, it cannot get below zero if the distances at both ends add up to more than L.
    """
    way = minus(leg.end, leg.start)
    first, last = passage(low, high, leg.start, way)
    if not first <= last:
        return np.inf
    gap, finish = distance_on(shape, leg, first) - kept, distance_on(shape, leg, last) - kept
    swelling = max(change_along(shape, leg, first), change_along(shape, leg, last))
    most = MARGIN * max(length(way) + swelling, STILL)
    if finish >= 0.0 and gap + finish > most * (last - first):
        return np.inf
    voxel = 1.0 / shape.before.per_metre
    near, far = first, first
    while gap >= 0.0:
        if far == last:
            return np.inf
        near, far = far, min(last, far + max(gap, LEAST * voxel) / most)
        gap = distance_on(shape, leg, far) - kept
    while (far - near) * most > SHARP * voxel:
        middle = 0.5 * (near + far)
        if distance_on(shape, leg, middle) < kept:
            far = middle
        else:
            near = middle
    return near


@inlined
def comes_by(boxes: np.ndarray, part: int, x: Vector, y: Vector) -> bool:
    """Tell whether the box around two points meets a part's."""
    meets = True
    for axis in range(3):
        meets = (
            meets and min(x[axis], y[axis]) <= boxes[part, 1, axis] and max(x[axis], y[axis]) >= boxes[part, 0, axis]
        )
    return meets


@inlined
def meeting_on_path(
    shape: Shape,
    low: Vector,
    high: Vector,
    stances: Stances,
    times: np.ndarray,
    x: Vector,
    y: Vector,
    kept: float,
    soonest: float,
) -> float:
    """Return the fraction of the way from x to y at which a part that moves gets nearer than `kept` [m], if sooner."""
    if is_clear(shape, stances, times, x, y, kept):
        return soonest
    legs = len(times) - 1
    end = place_in(stances, 0, shape.part, x)
    for t in range(legs):
        if t / legs >= soonest:
            break
        start, end = end, place_in(stances, t + 1, shape.part, mix(x, y, (t + 1) / legs))
        found = meeting(shape, Leg(start, end, times[t], times[t + 1]), low, high, kept)
        if found < np.inf:
            return min(soonest, (t + found) / legs)
    return soonest


@inlined
def is_clear(shape: Shape, stances: Stances, times: np.ndarray, x: Vector, y: Vector, kept: float) -> bool:
    """Tell whether the way from x to y, as a part sees it, is too short to get nearer than `kept` [m] on it."""
    legs = len(times) - 1
    start = end = place_in(stances, 0, shape.part, x)
    way = 0.0
    for t in range(legs):
        last, end = end, place_in(stances, t + 1, shape.part, mix(x, y, (t + 1) / legs))
        way += length(minus(end, last))
    leg = Leg(start, end, times[0], times[legs])
    before, after = distance_on(shape, leg, 0.0) - kept, distance_on(shape, leg, 1.0) - kept
    swelling = max(change_along(shape, leg, 0.0), change_along(shape, leg, 1.0))
    return after >= 0.0 and before + after > MARGIN * (way + swelling)


@njit(cache=True, parallel=True)
def sweep_parts(
    before: PartField,
    after: PartField,
    changes: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    stances: Stances,
    boxes: np.ndarray,
    times: np.ndarray,
    begin: np.ndarray,
    finish: np.ndarray,
    thickness: np.ndarray,
    fraction: np.ndarray,
) -> None:
    """Write, in place, meetings that are sooner than `fraction`; a Sweep, unpacked.

    changes    whether the parts have another shape in the second frame, (G,)
    low, high  corners of the box around a part in its frame [m], (G, 3)
    stances    of the parts at `times`, even, since the first frame [frames], (T,)
    boxes      around the parts in the world at all these times [m], (G, 2, 3)
    """
    for chunk in prange((len(begin) + CHUNK - 1) // CHUNK):
        for i in range(chunk * CHUNK, min(len(begin), (chunk + 1) * CHUNK)):
            x, y = (begin[i, 0], begin[i, 1], begin[i, 2]), (finish[i, 0], finish[i, 1], finish[i, 2])
            kept = -1.0
            for part in range(len(changes)):
                if not comes_by(boxes, part, x, y):
                    continue
                if kept < 0.0:
                    _, phi = nearest_part(before, after, changes, stances, 0, boxes, times[0], x)
                    kept = min(thickness[i], phi, 0.5 * before.background)
                    if phi <= 0.0:
                        break
                corner, other = (
                    (low[part, 0], low[part, 1], low[part, 2]),
                    (high[part, 0], high[part, 1], high[part, 2]),
                )
                shape = Shape(before, after, changes, part)
                fraction[i] = meeting_on_path(shape, corner, other, stances, times, x, y, kept, fraction[i])
