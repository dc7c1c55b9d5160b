"""Four particles on a line, whose altitude has no direction: the last resort of Sec. 3.1.

The second and the third are displaced by a tiny fraction of the extent, in directions that depend only on the line.
The shortest altitude of the resulting tetrahedron is chosen as usual: its length is nearly 0, its direction normal to
the line, and its weights are valid, so the full force of the spring moves the particles off the line. The displacement
fades in where rounding begins to blur the true direction, without a jump.

We differ from the paper and its code, which ignore the true direction below an angle of 7.6 degrees and then measure
only the overlap of two edges. The losses: the side from which the particles came to the line is not stored, the
direction changes abruptly as the line passes a diagonal of the axes, and angular momentum is conserved only up to the
size of the displacement.
"""

from collections.abc import Callable
from typing import Any

from numba import types
from numba.core.extending import overload

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import maximum, minimum, select, sqrt
from hairpipe.kernels.vec3 import cross, dot, plus, scaled


def nothing(x: Any) -> Any:
    """Return a tiny positive number of the lanes' precision [1]."""


def _limits(x: Any) -> Any:
    """Thickness over extent that collinear particles are given, and |N|^2 over extent^4 below which they are."""


@overload(nothing, strict=False)
def _nothing(x: Any) -> Callable:
    value = 1e-200 if x.dtype == types.float64 else 1e-36
    return lambda x: value


@overload(_limits, strict=False)
def _limits_of(x: Any) -> Callable:
    values = (2e-8, 1e-16) if x.dtype == types.float64 else (1e-4, 1e-9)
    return lambda x: values


@inlined
def _limit(u, v, w):
    extent = dot(u, u) + dot(v, v) + dot(w, w)
    return _limits(extent)[1] * extent * extent


@inlined
def collinear(u, v, w, size):
    """Particles so close to a line that their altitude is lost in rounding.

    u, v, w  from particle 0 to the others [m], tuples of three lanes; size  the largest |N|^2 there is [m^4]
    """
    return size < _limit(u, v, w)


@inlined
def off_the_line(u, v, w, size, where):
    """Return u and v [m], displaced where the particles are collinear."""
    along = _longer(u, _longer(v, w))
    aside = cross(along, _least_axis(along))
    limit = maximum(_limit(u, v, w), nothing(size))
    # The last factor is 0 at the limit: the displacement fades in, and the force does not jump there.
    reach = _limits(size)[0] * sqrt(dot(along, along)) * (1.0 - size / limit)
    b = plus(u, scaled(reach, _unit(aside)))
    c = plus(v, scaled(reach, _unit(cross(along, aside))))
    return _where(where, b, u), _where(where, c, v)


@inlined
def _where(condition, a, b):
    return select(condition, a[0], b[0]), select(condition, a[1], b[1]), select(condition, a[2], b[2])


@inlined
def _longer(a, b):
    return _where(dot(b, b) > dot(a, a), b, a)


@inlined
def _unit(a):
    """Vector of length 1, or 0."""
    return scaled(1.0 / sqrt(maximum(dot(a, a), nothing(a[0]))), a)


@inlined
def _least_axis(a):
    """Coordinate axis that a vector is least along."""
    xx, yy, zz = a[0] * a[0], a[1] * a[1], a[2] * a[2]
    x = select(minimum(yy, zz) < xx, 0.0 * xx, 1.0 + 0.0 * xx)
    y = (1.0 - x) * select(zz < yy, 0.0 * xx, 1.0 + 0.0 * xx)
    return x, y, 1.0 - x - y
