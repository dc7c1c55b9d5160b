"""Distance, normal and velocity of a body in parts at many points."""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector
from hairpipe.levelset.parts.field import PartField
from hairpipe.levelset.parts.pose_path import Stances
from hairpipe.levelset.parts.shape import (
    place_in,
    shape_change,
    shape_distance,
    shape_gradient,
    turned_out,
    velocity_of,
)

CHUNK = 512
"""Points that a thread takes at a time."""
# Of a distance. Where it is less steep, half way between two sheets, the shape's own motion is not told by it.
STEEP = 0.5


@inlined
def is_within(boxes: np.ndarray, part: int, x: Vector) -> bool:
    """Tell whether a point is in a part's box."""
    inside = boxes[part, 0, 0] <= x[0] <= boxes[part, 1, 0] and boxes[part, 0, 1] <= x[1] <= boxes[part, 1, 1]
    return inside and boxes[part, 0, 2] <= x[2] <= boxes[part, 1, 2]


@inlined
def nearest_part(
    before: PartField,
    after: PartField,
    changes: np.ndarray,
    stances: Stances,
    t: int,
    boxes: np.ndarray,
    a: float,
    x: Vector,
) -> tuple[int, float]:
    """Return the part nearest to a point, -1 where none is in reach, and its signed distance [m]."""
    found, nearest = -1, before.background
    for part in range(len(changes)):
        if is_within(boxes, part, x):
            phi = shape_distance(before, after, changes, part, a, place_in(stances, t, part, x))
            if phi < nearest:
                found, nearest = part, phi
    return found, nearest


@njit(cache=True, parallel=True)
def probe_parts(
    before: PartField,
    after: PartField,
    changes: np.ndarray,
    stances: Stances,
    boxes: np.ndarray,
    a: float,
    frame: float,
    points: np.ndarray,
    distance: np.ndarray,
    normal: np.ndarray,
    velocity: np.ndarray,
) -> None:
    """Write, in place, what the body is like where it is nearer than `distance`; a Probe, unpacked.

    changes  whether the parts have another shape in the second frame, (G,)
    stances  of the parts at one time, a frames after the first
    boxes    around the parts in the world [m], (G, 2, 3)
    """
    for chunk in prange((len(points) + CHUNK - 1) // CHUNK):
        for i in range(chunk * CHUNK, min(len(points), (chunk + 1) * CHUNK)):
            x = (points[i, 0], points[i, 1], points[i, 2])
            part, phi = nearest_part(before, after, changes, stances, 0, boxes, a, x)
            if part < 0 or not phi < distance[i]:
                continue
            X = place_in(stances, 0, part, x)
            g = turned_out(stances, 0, part, shape_gradient(before, after, changes, part, a, X))
            steep = np.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2])
            scale = 1.0 / steep if steep > 0.0 else 0.0
            swell = -shape_change(before, after, changes, part, X) / (frame * max(steep, STEEP)) * scale
            carried = velocity_of(stances, 0, part, x)
            distance[i] = phi
            for axis in range(3):
                normal[i, axis] = scale * g[axis]
                velocity[i, axis] = carried[axis] + swell * g[axis]
