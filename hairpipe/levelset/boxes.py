"""Boxes along the axes."""

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector


@inlined
def passage(low: Vector, high: Vector, start: Vector, way: Vector) -> tuple[float, float]:
    """Return the fractions of a way at which it enters and leaves a box; the first is the smaller unless it misses."""
    first, last = 0.0, 1.0
    for axis in range(3):
        near, far, step = low[axis] - start[axis], high[axis] - start[axis], way[axis]
        if step != 0.0:
            first, last = max(first, min(near / step, far / step)), min(last, max(near / step, far / step))
        elif not near <= 0.0 <= far:
            last = -1.0
    return first, last
