"""Bending of a plain chain of points, as an elastic rod of isotropic section would resist it.

    E = B / 2 |x_p - 2 x_p+1 + x_p+2|^2,   f = -B (1, -2, 1)^T (x_p - 2 x_p+1 + x_p+2),   B = E I / l^3

The second difference over l^2 is the curvature, exact to (angle)^2 / 24 where l keeps its length. The energy is
quadratic, so force and stiffness are exact and the stiffness never changes. The rod is straight at rest and has no
torsion.

Source: Bergou et al., A Quadratic Bending Model for Inextensible Surfaces, 2006, in one dimension.
"""

from hairpipe.geometry.banded import add_coupling, add_diagonal
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import load, store


@inlined
def add_bending(A, b, x, p, stiffness, h, hh):
    """Add h f to b and hh K to A for particles p, p + 1 and p + 2, in place.

    x          positions [m], (particles, 3, W)
    stiffness  B = E I / l^3 [N/m]; h  step [s]; hh  its square, or 0 for a force that is not implicit [s^2]
    """
    for c in range(3):
        f = h * stiffness * (load(x, (p, c)) - 2.0 * load(x, (p + 1, c)) + load(x, (p + 2, c)))
        store(b, (p, c), load(b, (p, c)) - f)
        store(b, (p + 1, c), load(b, (p + 1, c)) + 2.0 * f)
        store(b, (p + 2, c), load(b, (p + 2, c)) - f)
    s = hh * stiffness
    _add_isotropic(A, p, s)
    _add_isotropic(A, p + 1, 4.0 * s)
    _add_isotropic(A, p + 2, s)
    zero = 0.0 * s  # K is isotropic: the three components are the same, and do not mix.
    add_coupling(A, p, 1, (-2.0 * s, zero, zero, -2.0 * s, zero, -2.0 * s))
    add_coupling(A, p + 1, 1, (-2.0 * s, zero, zero, -2.0 * s, zero, -2.0 * s))
    add_coupling(A, p, 2, (s, zero, zero, s, zero, s))


@inlined
def _add_isotropic(A, p, s):
    zero = 0.0 * s
    add_diagonal(A, p, s, zero, zero, s, zero, s)
