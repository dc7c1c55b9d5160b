"""First contact of a moving point with a body: sphere tracing along its path.

The distance at a point bounds the free path. Along a ray over which the distance changes by at most L, a step of d / L
from a point at distance d does not pass the surface; the last step is bisected.

Source: J. C. Hart, Sphere tracing: a geometric method for the antialiased ray tracing of implicit surfaces, 1996. We
differ from the paper: the body moves along the ray, and L is estimated at the ends of the ray (`MARGIN`).
"""

from typing import NamedTuple

import numpy as np

from hairpipe.geometry.collider import Walk
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import Vector, length, minus, plus, row, scaled

MARGIN = 1.25
"""Factor by which the distance may change faster between the ends of a ray than it is known to there."""
STILL = 1e-12
"""A ray as short as this is a point [m]."""
# Of the spacing of samples: the shortest step, and how exactly a hit is known. A level set has no shape much finer than
# its samples, and hair that slides along a body takes the shortest step all the way.
_LEAST, _SHARP = 0.25, 1e-2


class SpaceTimeRay(NamedTuple):
    """A straight line through space and time; a fraction 0 to 1 is a point on it."""

    start: Vector  # [m]
    way: Vector  # from start to end [m]
    a: float  # time of the start since the first frame [frames]
    da: float  # duration [frames]


class Span(NamedTuple):
    """The end of the part of a ray on which a body may be hit, with bounds of the distance."""

    last: float  # fraction of the ray
    change: float  # largest change of the distance over the whole ray [m]
    voxel: float  # spacing of the samples of the distance [m]


@inlined
def is_clear(walk: Walk, i: int, change: float) -> bool:
    """Return whether point i of a walk is known to stay clear of a body that moves by at most a change [m].

    If the distance changes by at most L over a path, it is nowhere below half of the sum of the distances at both ends
    minus L.
    """
    way = length(minus(row(walk.after, i), row(walk.before, i))) + change
    return walk.begin[i] + walk.finish[i] - 2.0 * walk.thickness[i] > MARGIN * way


@inlined
def point_on(ray: SpaceTimeRay, s: float) -> Vector:
    """Return the place of a fraction of a ray [m]."""
    return plus(ray.start, scaled(s, ray.way))


@inlined
def time_on(ray: SpaceTimeRay, s: float) -> float:
    """Return the time of a fraction of a ray, since the first frame [frames]."""
    return ray.a + s * ray.da


@inlined
def crossed_box(low: Vector, high: Vector, ray: SpaceTimeRay) -> tuple[float, float]:
    """Return the fractions at which a ray enters and leaves a box along the axes; the first is larger if it misses."""
    first, last = 0.0, 1.0
    for axis in range(3):
        near = low[axis] - ray.start[axis]
        far = high[axis] - ray.start[axis]
        step = ray.way[axis]
        if step != 0.0:  # Without motion along an axis the ray is between the two faces all the way, or nowhere.
            first = max(first, min(near / step, far / step))
            last = min(last, max(near / step, far / step))
        elif not near <= 0.0 <= far:
            last = -1.0
    return first, last


class Trace(NamedTuple):
    """A search for the first hit along a ray, by fractions of the ray."""

    near: float  # last one known to be clear; inf after a ray without a hit
    far: float  # first one known to be hit; inf: none yet
    at: float  # the one whose distance is required next


@inlined
def traced(trace: Trace, span: Span, gap: float) -> Trace:
    """Return a trace after the distance where it is at, minus the threshold [m]: a step further, or a bisection."""
    near, far = trace.near, trace.far
    if gap < 0.0:
        far = trace.at
    else:
        near = trace.at
    at = 0.5 * (near + far)
    if far == np.inf:
        # A shortest step, or steps would vanish where the ray grazes the surface.
        at = min(span.last, near + max(_LEAST * span.voxel, gap) / span.change)
        if near == span.last:
            near = np.inf
    return Trace(near, far, at)


@inlined
def is_open(trace: Trace, span: Span) -> bool:
    """Return whether the first hit is not yet found: by its distance, not by its fraction."""
    is_unclear = trace.far == np.inf or (trace.far - trace.near) * span.change > _SHARP * span.voxel
    return is_unclear and trace.near < np.inf
