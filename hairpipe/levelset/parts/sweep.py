"""Time at which moving points hit a body in parts, each of which is at rest in its own frame."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, length, minus, mix, row
from hairpipe.levelset.collider import Walk
from hairpipe.levelset.parts.field import PartField
from hairpipe.levelset.parts.pose_path import PartPoses
from hairpipe.levelset.parts.probe import nearest_part
from hairpipe.levelset.parts.shape import Shape, place_in, shape_change, shape_distance
from hairpipe.levelset.sphere_tracing import (
    MARGIN,
    STILL,
    SpaceTimeRay,
    Span,
    Trace,
    crossed_box,
    is_clear,
    is_open,
    point_on,
    time_on,
    traced,
)

CHUNK = 512
"""Points that a thread takes at a time."""


class Outlines(NamedTuple):
    """Outlines of G parts in their own frames.

    changes    whether the shape of a part differs between the frames, (G,) bool
    low, high  corners of the box around a part [m], (G, 3) float64
    """

    changes: np.ndarray
    low: np.ndarray
    high: np.ndarray


@inlined
def distance_on(shape: Shape, ray: SpaceTimeRay, s: float) -> float:
    """Return the distance [m] to a part at a fraction s of a ray in its frame."""
    return shape_distance(shape, time_on(ray, s), point_on(ray, s))


@inlined
def swelling_along(shape: Shape, ray: SpaceTimeRay, first: float, last: float) -> float:
    """Return how much the part's change of shape changes the distance over a ray, as at two fractions of it [m]."""
    before, after = shape_change(shape, point_on(ray, first)), shape_change(shape, point_on(ray, last))
    return max(abs(before) * ray.da, abs(after) * ray.da)


@inlined
def first_hit(shape: Shape, ray: SpaceTimeRay, low: Vector, high: Vector, kept: float) -> float:
    """Return the fraction of a ray in a part's frame at which the distance falls below `kept` [m], or inf.

    low, high  corners of the part's box [m]

    If the distance changes by at most L over a ray, and the distances at both ends add up to more, it stays positive.
    """
    first, last = crossed_box(low, high, ray)
    if not first <= last:
        return np.inf
    gap, finish = distance_on(shape, ray, first) - kept, distance_on(shape, ray, last) - kept
    change = MARGIN * max(length(ray.way) + swelling_along(shape, ray, first, last), STILL)
    if finish >= 0.0 and gap + finish > change * (last - first):
        return np.inf
    span = Span(last, change, 1.0 / shape.before.per_metre)
    trace = traced(Trace(first, np.inf, first), span, gap)
    while is_open(trace, span):
        trace = traced(trace, span, distance_on(shape, ray, trace.at) - kept)
    return trace.near


@inlined
def meets_box(boxes: np.ndarray, part: int, x: Vector, y: Vector) -> bool:
    """Return whether the box around two points meets a part's."""
    meets = True
    for axis in range(3):
        meets = (
            meets and min(x[axis], y[axis]) <= boxes[part, 1, axis] and max(x[axis], y[axis]) >= boxes[part, 0, axis]
        )
    return meets


@inlined
def first_hit_on_path(
    shape: Shape, outlines: Outlines, part_poses: PartPoses, x: Vector, y: Vector, kept: float, soonest: float
) -> float:
    """Return the fraction of the way from x to y at which a part that moves gets nearer than `kept` [m], if sooner."""
    if stays_clear(shape, part_poses, x, y, kept):
        return soonest
    times = part_poses.times
    legs = len(part_poses.times) - 1
    low, high = row(outlines.low, shape.part), row(outlines.high, shape.part)
    end = place_in(part_poses, 0, shape.part, x)
    for t in range(legs):
        if t / legs >= soonest:  # Another part was hit before this leg begins.
            break
        start = end
        end = place_in(part_poses, t + 1, shape.part, mix(x, y, (t + 1) / legs))
        ray = SpaceTimeRay(start, minus(end, start), times[t], times[t + 1] - times[t])
        found = first_hit(shape, ray, low, high, kept)
        if found < np.inf:
            return min(soonest, (t + found) / legs)  # Legs follow each other in time: the first hit is the soonest.
    return soonest


@inlined
def stays_clear(shape: Shape, part_poses: PartPoses, x: Vector, y: Vector, kept: float) -> bool:
    """Return whether the path from x to y in the frame of a part is too short to get nearer than `kept` [m]."""
    times = part_poses.times
    legs = len(part_poses.times) - 1
    start = end = place_in(part_poses, 0, shape.part, x)
    way = 0.0
    for t in range(legs):
        last = end
        end = place_in(part_poses, t + 1, shape.part, mix(x, y, (t + 1) / legs))
        way += length(minus(end, last))  # The way as the part sees it, leg by leg: the part's own turning is in it.
    ray = SpaceTimeRay(start, minus(end, start), times[0], times[legs] - times[0])
    before, after = distance_on(shape, ray, 0.0) - kept, distance_on(shape, ray, 1.0) - kept
    return after >= 0.0 and before + after > MARGIN * (way + swelling_along(shape, ray, 0.0, 1.0))


@njit(cache=True, parallel=True)
def sweep_parts(
    before: PartField,
    after: PartField,
    outlines: Outlines,
    part_poses: PartPoses,
    boxes: np.ndarray,
    walk: Walk,
    farthest: float,
    fraction: np.ndarray,
) -> None:
    """Write the hits before `fraction` of points that move from the first of the times to the last, in place.

    stances   stances of the parts at equidistant times
    boxes     boxes around the parts in the world at all these times [m], (G, 2, 3)
    farthest  longest displacement of a part [m]
    """
    count = len(walk.thickness)
    changes = outlines.changes
    for chunk in prange((count + CHUNK - 1) // CHUNK):
        for i in range(chunk * CHUNK, min(count, (chunk + 1) * CHUNK)):
            if is_clear(walk, i, farthest):
                continue
            x, y = row(walk.before, i), row(walk.after, i)
            kept = -1.0
            for part in range(len(changes)):
                if not meets_box(boxes, part, x, y):
                    continue
                if kept < 0.0:
                    _, phi = nearest_part(before, after, changes, part_poses, boxes, x)
                    kept = min(walk.thickness[i], phi, 0.5 * before.background)
                    if phi <= 0.0:  # It begins inside: to come out is not a hit.
                        break
                shape = Shape(before, after, changes, part)
                fraction[i] = first_hit_on_path(shape, outlines, part_poses, x, y, kept, fraction[i])
