"""Hair that is drawn to other places and keeps its lengths: point after point, from the root on.

    x_k+1 = x_k + l_k d,   d = (y_k+1 - x_k) / |y_k+1 - x_k|

with y where points are drawn to. Hair changes no more than it must: an error of one point is not that of all beyond it.
"""

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import Vector, flattened, length, minus, plus, scaled


@inlined
def drawn_to(x: Vector, y: Vector, l: float) -> Vector:
    """Return the point at a distance l [m] from x towards y [m]; y itself where it is there."""
    way = minus(y, x)
    size = length(way)
    return plus(x, scaled(l / size, way)) if size > 0.0 else y


@inlined
def speed_of_drawn(x: Vector, v: Vector, y: Vector, speed: Vector, l: float) -> Vector:
    """Return the velocity [m/s] of what `drawn_to` returns, where x goes at v and y at a speed."""
    way = minus(y, x)
    size = length(way)
    return plus(v, scaled(l / size, flattened(minus(speed, v), scaled(1.0 / size, way)))) if size > 0.0 else speed
