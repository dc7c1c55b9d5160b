"""Adds vertices of a rod to the banded matrix of a strand, whose rows are `kernels/banded_angle.py`.

A vertex at row p + 1 moves nodes p, p + 1 and p + 2, and the angles of the two edges between: its edges are e = x_p+1 -
x_p and f = x_p+2 - x_p+1. Angles are multiplied by a length, so that all unknowns have similar magnitudes.
"""

from hairpipe.kernels import sym3
from hairpipe.kernels.banded import add
from hairpipe.kernels.banded_angle import add_point
from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import minus, plus, scaled
from hairpipe.sim.strands.rod.vertex import Gradient, Tangent


@inlined
def in_unknowns(H, s, inverse):
    """Return s times a tangent, by angles times a length; inverse  1 / that length [1/m]."""
    ef = H.ef
    a = s * inverse
    x, y, z = scaled(s, ef[0:3]), scaled(s, ef[3:6]), scaled(s, ef[6:9])
    return Tangent(
        sym3.times(s, H.ee),
        (x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]),
        sym3.times(s, H.ff),
        scaled(a, H.e_a),
        scaled(a, H.e_b),
        scaled(a, H.f_a),
        scaled(a, H.f_b),
        a * inverse * H.aa,
        a * inverse * H.ab,
        a * inverse * H.bb,
    )


@inlined
def add_gradient(b, p, h, inverse, g: Gradient):
    """Add h times the forces of a vertex at row p + 1, the negative of its gradient, in place."""
    e, f = scaled(h, g.e), scaled(h, g.f)
    for c in range(3):
        add(b, p, c, e[c])
        add(b, p + 1, c, f[c] - e[c])
        add(b, p + 2, c, -f[c])
    add(b, p, 3, -h * inverse * g.a)
    add(b, p + 1, 3, -h * inverse * g.b)


@inlined
def _less(nine, six):
    """A block row by row less a symmetric one."""
    x = minus(nine[0:3], six[0:3])
    y = minus(nine[3:6], (six[1], six[3], six[4]))
    z = minus(nine[6:9], (six[2], six[4], six[5]))
    return x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]


@inlined
def _add_columns(A, p, column, nine):
    """Add a block row by row to the three columns of position rows from a column on, counted from the first unknown."""
    for c in range(3):
        add(A, p, column + c, nine[c])
        add(A, p, 10 + column + c, nine[3 + c])
        add(A, p, 19 + column + c, nine[6 + c])


@inlined
def _add_column(A, p, column, three):
    add(A, p, column, three[0])
    add(A, p, 10 + column, three[1])
    add(A, p, 19 + column, three[2])


@inlined
def _add_angle(A, p, column, three):
    """Add three numbers to the row of the angle of p, from a column on."""
    for c in range(3):
        add(A, p, 27 + column + c, three[c])


@inlined
def add_tangent(A, p, H: Tangent):
    """Add the tangent of a vertex at row p + 1, in place."""
    ee, ff, m = H.ee, H.ff, H.ef
    # e = x_p+1 - x_p and f = x_p+2 - x_p+1: row p gets -1 times blocks of e, row p + 1 those of e minus those of f.
    add_point(A, p, ee)
    _add_column(A, p, 3, scaled(-1.0, H.e_a))
    _add_columns(A, p, 4, _less(m, ee))
    _add_column(A, p, 7, scaled(-1.0, H.e_b))
    _add_columns(A, p, 8, (-m[0], -m[1], -m[2], -m[3], -m[4], -m[5], -m[6], -m[7], -m[8]))
    add(A, p, 30, H.aa)
    _add_angle(A, p, 4, minus(H.e_a, H.f_a))
    add(A, p, 34, H.ab)
    _add_angle(A, p, 8, H.f_a)
    both = m[0] + m[0], m[1] + m[3], m[2] + m[6], m[4] + m[4], m[5] + m[7], m[8] + m[8]
    add_point(A, p + 1, sym3.minus(sym3.plus(ee, ff), both))
    _add_column(A, p + 1, 3, minus(H.e_b, H.f_b))
    _add_columns(A, p + 1, 4, _less(m, ff))
    add(A, p + 1, 30, H.bb)
    _add_angle(A, p + 1, 4, H.f_b)
    add_point(A, p + 2, ff)


@inlined
def added_to_f(H, six):
    """Return a tangent with a symmetric block more by f."""
    return Tangent(H.ee, H.ef, sym3.plus(H.ff, six), H.e_a, H.e_b, H.f_a, H.f_b, H.aa, H.ab, H.bb)


@inlined
def held_at_angles(H, a, b):
    """Return a tangent with so much more on the diagonal of both angles."""
    return Tangent(H.ee, H.ef, H.ff, H.e_a, H.e_b, H.f_a, H.f_b, H.aa + a, H.ab, H.bb + b)


@inlined
def pulled_at_f(g, force):
    """Return a gradient with so much more by f."""
    return Gradient(g.e, plus(g.f, force), g.a, g.b)
