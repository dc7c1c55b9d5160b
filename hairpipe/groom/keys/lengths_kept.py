"""The next point of a hair of given length, in a given direction: how everything that moves interpolated hair ends."""

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, flattened, length, plus, scaled

_TINY = 1e-12  # of a segment; a way that is shorter has no direction


@inlined
def go_on(x: Vector, v: Vector, l: float, way: Vector, speed: Vector) -> tuple[Vector, Vector]:
    """Return the point at a distance l [m] from x along a way [m], x + l way/|way|, and its velocity [m/s].

    A way that has no direction, as where keys are opposed, goes down.

    v      of x [m/s]
    speed  at which the way changes [m/s]
    """
    size = length(way)
    if size <= _TINY * l:
        return plus(x, (0.0, -l, 0.0)), v
    t = scaled(1.0 / size, way)
    return plus(x, scaled(l, t)), plus(v, scaled(l / size, flattened(speed, t)))
