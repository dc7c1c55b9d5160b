"""Distance, normal and velocity of a body in parts at many points."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, length, row
from hairpipe.levelset.parts.field import PartField
from hairpipe.levelset.parts.pose_path import PartPoses
from hairpipe.levelset.parts.shape import (
    Shape,
    place_in,
    shape_change,
    shape_distance,
    shape_gradient,
    turned_out,
    velocity_of,
)

CHUNK = 512
"""Points that a thread takes at a time."""
# Least slope of a distance: half way between two sheets, where it is flatter, it does not give the shape's own speed.
STEEP = 0.5


@inlined
def is_within(boxes: np.ndarray, part: int, x: Vector) -> bool:
    """Return whether a point is in a part's box."""
    inside = boxes[part, 0, 0] <= x[0] <= boxes[part, 1, 0] and boxes[part, 0, 1] <= x[1] <= boxes[part, 1, 1]
    return inside and boxes[part, 0, 2] <= x[2] <= boxes[part, 1, 2]


@inlined
def nearest_part(
    before: PartField, after: PartField, changes: np.ndarray, part_poses: PartPoses, boxes: np.ndarray, x: Vector
) -> tuple[int, float]:
    """Return the part nearest to a point at the first of the times, -1 where none is in reach, and its distance [m]."""
    found = -1
    nearest = before.background
    for part in range(len(changes)):
        if is_within(boxes, part, x):  # Beyond its box a part is no nearer than the border of the band.
            shape = Shape(before, after, changes, part)
            phi = shape_distance(shape, part_poses.times[0], place_in(part_poses, 0, part, x))
            if phi < nearest:
                found, nearest = part, phi
    return found, nearest


class Places(NamedTuple):
    """Data of G parts at one time for a query.

    changes  whether the shape of a part differs in the second frame, (G,) bool
    boxes    boxes around the parts in the world [m], (G, 2, 3)
    frame    time between the frames [s]
    reach    distance from which on only the distance of a point is queried [m], (P,)
    """

    changes: np.ndarray
    boxes: np.ndarray
    frame: float
    reach: np.ndarray


@njit(cache=True, parallel=True)
def probe_parts(
    before: PartField,
    after: PartField,
    part_poses: PartPoses,
    parts: Places,
    points: np.ndarray,
    distance: np.ndarray,
    normal: np.ndarray,
    velocity: np.ndarray,
) -> None:
    """Write the sample of the body where it is nearer than `distance`, in place; a SdfSample, unpacked.

    stances  stances of the parts at one time
    """
    changes, boxes, frame, reach = parts.changes, parts.boxes, parts.frame, parts.reach
    for chunk in prange((len(points) + CHUNK - 1) // CHUNK):
        for i in range(chunk * CHUNK, min(len(points), (chunk + 1) * CHUNK)):
            x = row(points, i)
            part, phi = nearest_part(before, after, changes, part_poses, boxes, x)
            if part < 0 or not phi < distance[i]:  # Written so that a NaN is not nearer.
                continue
            distance[i] = phi
            if not phi < reach[i]:  # Normal and velocity cost more, and are asked for within reach only.
                continue
            shape = Shape(before, after, changes, part)
            X = place_in(part_poses, 0, part, x)
            g = turned_out(part_poses, 0, part, shape_gradient(shape, part_poses.times[0], X))
            steep = length(g)
            scale = 1.0 / steep if steep > 0.0 else 0.0
            # u = (phi_0 - phi_1) / (dt |grad f|) along the normal; the slope is bounded, see `STEEP`.
            swell = -shape_change(shape, X) / (frame * max(steep, STEEP)) * scale
            advected = velocity_of(part_poses, 0, part, x)
            for axis in range(3):
                normal[i, axis] = scale * g[axis]
                velocity[i, axis] = advected[axis] + swell * g[axis]
