"""Linear springs: Sec. 3.2 and the implicit linear spring of Sec. 4.1, with its tension term.

    f_p = k (l / l0 - 1) d + c (d . (v_q - v_p)) d,  f_q = -f_p,  d = (x_q - x_p) / l
    K = (k / l0) d d^T + max(T, 0) / l (I - d d^T),   D = c d d^T

k is a force per unit strain [N], c = 2 z sqrt(k m / l0) a fraction z of critical damping, m = m_p m_q / (m_p + m_q).
The model defines the pairs of edges, bending and torsion springs, `laws/stretch.py` defines T. For T < 0 the
term is omitted, so that K stays positive semidefinite.

We differ from the paper, which keeps only the first term of K (T = 0 here): hair hanging under gravity then diverges
above a few milliseconds.

Stiffness of a spring in the matrix of a solve: K, and its tension T.
"""

from enum import IntEnum

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import difference, load, maximum, sqrt
from hairpipe.geometry.sym3 import outer
from hairpipe.geometry.vec3 import dot, scaled

_SMALLEST = 1e-12  # [m]; a segment shorter than this has no direction and gets no force


@inlined
def _direction(x, p, q):
    """Unit vector from p to q, length [m] and its inverse."""
    span = difference(x, p, q)
    length = maximum(sqrt(dot(span, span)), _SMALLEST)
    inverse = 1.0 / length
    return scaled(inverse, span), length, inverse


@inlined
def critical_damping(k, inverse_rest, mass, p, q):
    """Critical damping of a spring between particles p and q [kg/s]: 2 sqrt(k m / l0)."""
    mp, mq = load(mass, (p,)), load(mass, (q,))
    return 2.0 * sqrt(k * inverse_rest * mp * mq / (mp + mq))


@inlined
def linearise_spring(at, p, offset, spring, h, hh):
    """Return h f on particle p and hh K + h D for the spring from there to p + offset.

    at      positions x [m] and velocities v [m/s], (particles, 3, W), and tensions for K [N], (particles, springs, W)
    spring  k, force per unit strain [N]; 1 / l0 [1/m]; c, damping [kg/s]
    h       step [s]; hh  its square, or 0 for a spring that is not implicit [s^2]
    """
    (x, v, T), (k, inverse_rest, c) = at, spring
    d, length, inverse = _direction(x, p, p + offset)
    closing = dot(d, difference(v, p, p + offset))
    f = h * (k * (inverse_rest * length - 1.0) + c * closing)
    t = hh * maximum(load(T, (p, offset - 1)), 0.0) * inverse
    xx, xy, xz, yy, yz, zz = outer(hh * k * inverse_rest + h * c - t, d)
    return scaled(f, d), (xx + t, xy, xz, yy + t, yz, zz + t)


@inlined
def multiplier(x, dx, p, offset, k, inverse_rest):
    """Return the tension of a spring after the linear solve: k (d . (x_q + dx_q - x_p - dx_p) / l0 - 1) [N].

    x   positions of the linearisation [m]; dx  displacement by the solve [m]; both (particles, 3, W)
    """
    d, length, _ = _direction(x, p, p + offset)
    return k * (inverse_rest * (length + dot(d, difference(dx, p, p + offset))) - 1.0)


@inlined
def tension(x, p, offset, k, inverse_rest):
    """Tension of a spring as it is stretched: k (l / l0 - 1) [N]."""
    return k * (inverse_rest * _direction(x, p, p + offset)[1] - 1.0)


class SpringForm(IntEnum):
    """The choices of K = (k / l0) d d^T + max(T, 0) / l (I - d d^T).

    explicit    K = 0: the force at the known positions; damping stays implicit
    printed     T = 0, Sec. 4.1 of Selle, Lentine, Fedkiw 2008: implicit along the spring only
    tension     T of the present stretch: stable, but the rotation of a stiff edge by theta within a step appears as a
                stretch by theta^2 / 2, and this spurious tension damps every swing
    multiplier  T of the previous solve: stable, without spurious tension
    """

    explicit = 0
    printed = 1
    tension = 2
    multiplier = 3
