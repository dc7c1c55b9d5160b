"""A body in parts between two frames: each part moves along its bone's path, with a blended shape.

    phi(x, a) = min_k f_k(R_k(a)^T (x - p_k(a)), a),   f_k(X, a) = (1 - a) phi_k0(X) + a phi_k1(X)
    v = dp/dt + omega x (x - p) + u n,   u = (phi_k0 - phi_k1) / (dt |grad f_k|)

with the path of `pose_path`. A part of constant shape is read once.

We differ from the paper (Selle et al. 2008, section 5), which blends one level set of the whole body along its mean
velocity: this needs no velocities, preserves the shape of rotating parts, and does not mix two close bodies.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import Vector, length, minus, mix, row
from hairpipe.levelset.collider import FirstHit, SdfSample, Walk
from hairpipe.levelset.grid_layout import BRICK
from hairpipe.levelset.parts_field import (
    PartField,
    PartPoses,
    PartsQuery,
    PosePath,
    Shape,
    largest_changes,
    nearest_part,
    part_field_of,
    part_poses_at,
    path_between,
    place_in,
    probe_parts,
    shape_change,
    shape_distance,
)
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
from hairpipe.values import BodyParts

CHUNK = 512  # points that a thread takes at a time


class Outlines(NamedTuple):
    """Outlines of G parts in their own frames."""

    changes: np.ndarray  # whether the shape of a part differs between the frames, (G,) bool
    low: np.ndarray  # lower corner of the box around a part [m], (G, 3) float64
    high: np.ndarray  # upper corner [m]


@inlined
def distance_on(shape: Shape, ray: SpaceTimeRay, s: float) -> float:
    return shape_distance(shape, time_on(ray, s), point_on(ray, s))


@inlined
def swelling_along(shape: Shape, ray: SpaceTimeRay, first: float, last: float) -> float:
    """Return how much the part's change of shape changes the distance over a ray, as at two fractions of it [m]."""
    before, after = shape_change(shape, point_on(ray, first)), shape_change(shape, point_on(ray, last))
    return max(abs(before) * ray.da, abs(after) * ray.da)


@inlined
def first_hit(shape: Shape, ray: SpaceTimeRay, low: Vector, high: Vector, kept: float) -> float:
    """Return the fraction of a ray in a part's frame at which the distance falls below `kept` [m], or inf.

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


# A part turns by no more than this from a sample of its pose to the next [rad], between which its points move straight.
FINE = 0.02
MOST_LOOKS = 64
_LOOKS = 5  # samples of a frame in which its fastest moment is looked for


@dataclass(frozen=True, eq=False)
class ColliderParts:
    """A body in parts between two frames; a Collider."""

    before: PartField
    after: PartField
    outlines: Outlines
    path: PosePath

    @property
    def speed(self) -> float:
        """Return an upper bound of the speed of parts [m/s]: of the fastest corner of a box, plus that of its shape.

        The corners are sampled at a few times, v + omega x (x - p).
        """
        return self._speed

    @cached_property
    def _speed(self) -> float:
        part_poses = part_poses_at(self.path, np.linspace(0.0, self.path.frame, _LOOKS))
        corners = np.stack(np.meshgrid(*3 * [[False, True]], indexing="ij"), axis=-1).reshape(-1, 3)
        arms = np.einsum(
            "tkxy,cky->ctkx", part_poses.turns, np.where(corners[:, None], self.outlines.high, self.outlines.low)
        )
        advected = np.linalg.norm(part_poses.drifts + np.cross(part_poses.spins, arms), axis=-1)
        return float((advected + self.swelling).max(initial=0.0))

    @cached_property
    def swelling(self) -> np.ndarray:
        """Speed of the shape of every part in its own frame [m/s], |phi_1 - phi_0| / dt where that is largest, (G,)."""
        return largest_changes(self.before, self.after, self.outlines.changes) / self.path.frame

    @property
    def band(self) -> float:
        """Distance beyond which the body is not found [m]."""
        return self.before.background

    def probe(self, points: np.ndarray, seconds: float, out: SdfSample, reach: np.ndarray | None = None) -> None:
        """Write what is nearer than out, in place; see Collider."""
        reach = np.full(len(points), np.inf) if reach is None else reach
        part_poses = part_poses_at(self.path, np.array([seconds]))
        parts = PartsQuery(self.outlines.changes, boxes_at(part_poses, self.outlines), self.path.frame, reach)
        probe_parts(self.before, self.after, part_poses, parts, points, *out)

    def sweep(self, walk: Walk, start: float, end: float, out: FirstHit) -> None:
        """Write hits that are sooner than out, in place; see Collider."""
        part_poses = part_poses_at(self.path, self.looks(start, end))
        boxes = boxes_at(part_poses, self.outlines)
        farthest = self.speed * (end - start)
        sweep_parts(self.before, self.after, self.outlines, part_poses, boxes, walk, farthest, out.fraction)

    def looks(self, start: float, end: float) -> np.ndarray:
        """Return even times from start to end [s] between which no part turns much, (T,)."""
        spins = part_poses_at(self.path, np.array([start, 0.5 * (start + end), end])).spins
        turn = np.sqrt((spins**2).sum(axis=2)).max() * (end - start)
        return np.linspace(start, end, 1 + min(MOST_LOOKS, 1 + int(turn / FINE)))


def build_collider_parts(before: BodyParts, after: BodyParts, frame: float) -> ColliderParts:
    """Build a body that moves from one frame to the next in a time [s]; BadInput if the frames have different parts."""
    if before.names != after.names or before.voxel != after.voxel or before.half_width != after.half_width:
        right = "parts baked from one body with the same settings"
        raise BadInput("the parts of the body are not the same at both frames", where="parts", right=right)
    low = np.minimum(before.origins, after.origins)
    highs = [parts.origins + BRICK * parts.voxel * parts.shapes for parts in (before, after)]
    path = path_between(before.poses, before.rates, after.poses, after.rates, frame)
    changes = np.array([not is_same(before, after, part) for part in range(len(before.names))])
    outlines = Outlines(changes, low, np.maximum(*highs))
    return ColliderParts(part_field_of(before), part_field_of(after), outlines, path)


def is_same(before: BodyParts, after: BodyParts, part: int) -> bool:
    """Return whether a part has the same samples in both frames, in bricks counted from its first."""
    if not np.array_equal(before.origins[part], after.origins[part]):
        return False
    if not np.array_equal(before.shapes[part], after.shapes[part]):
        return False
    samples = []
    for parts in (before, after):
        index = parts.bricks[parts.starts[part] : parts.starts[part + 1]]
        count = int((index >= 0).sum())
        first = int(index[index >= 0].min()) if count else 0
        samples.append((np.where(index >= 0, index - first, index), parts.distance[first : first + count]))
    return all(np.array_equal(*both) for both in zip(*samples, strict=True))


@njit(cache=True)
def boxes_at(part_poses: PartPoses, outlines: Outlines) -> np.ndarray:
    """Return low and high corner, in the world, of the box around every part at all times together [m], (G, 2, 3)."""
    low, high = outlines.low, outlines.high
    boxes = np.empty((len(low), 2, 3))
    boxes[:, 0], boxes[:, 1] = np.inf, -np.inf
    for t in range(len(part_poses.turns)):
        for k in range(len(low)):
            for x in range(3):
                middle = part_poses.places[t, k, x]
                half = 0.0
                for y in range(3):
                    turn = part_poses.turns[t, k, x, y]
                    middle += 0.5 * turn * (low[k, y] + high[k, y])
                    # The box around a turned box: its half edges are those of the part times |R|.
                    half += 0.5 * abs(turn) * (high[k, y] - low[k, y])
                boxes[k, 0, x] = min(boxes[k, 0, x], middle - half)
                boxes[k, 1, x] = max(boxes[k, 1, x], middle + half)
    return boxes
