"""Edge, bending and torsion springs: Sec. 3.2 and the implicit linear spring of Sec. 4.1, with its tension term.

    f_p = k (l / l0 - 1) d,  f_q = -f_p,  d = (x_q - x_p) / l
    K = (k / l0) d d^T + max(T, 0) / l (I - d d^T)

k is a force per unit strain [N]. Which pairs are edges, bending or torsion springs is the lattice's business.

We differ from the paper, which keeps only the first term of K: hair hanging under gravity then diverges above a few
milliseconds. T is the multiplier of the solve before, T = k (d . (x_q - x_p) / l0 - 1) after it: taken
from the present stretch instead it would damp every swing. For T < 0 the term is left out, so that K
stays positive semidefinite.
"""

from numba import njit

from hairpipe.sim.banded import add_coupling, add_diagonal
from hairpipe.sim.lanes import load, maximum, sqrt, store

_SMALLEST = 1e-12  # [m]; a segment shorter than this has no direction and gets no force


@njit(cache=True)
def _direction(x, p, q):  # noqa: ANN001, ANN202
    dx = load(x, (q, 0)) - load(x, (p, 0))
    dy = load(x, (q, 1)) - load(x, (p, 1))
    dz = load(x, (q, 2)) - load(x, (p, 2))
    inverse = 1.0 / maximum(sqrt(dx * dx + dy * dy + dz * dz), _SMALLEST)
    return dx * inverse, dy * inverse, dz * inverse, inverse


@njit(cache=True)
def add_spring(A, b, x, T, p, offset, k, inverse_rest, h):  # noqa: ANN001, ANN201
    """Add h f to b and h^2 K to A for the spring from particle p to p + offset, in place.

    x             positions [m], (particles, 3, WIDTH)
    T             multipliers of the last solve [N], (particles, 3, WIDTH), by offset
    k             force per unit strain [N]; inverse_rest  1 / l0 [1/m]; h  step [s]
    """
    q = p + offset
    dx, dy, dz, inverse = _direction(x, p, q)
    f = h * k * (inverse_rest / inverse - 1.0)
    fx, fy, fz = f * dx, f * dy, f * dz
    store(b, (p, 0), load(b, (p, 0)) + fx)
    store(b, (p, 1), load(b, (p, 1)) + fy)
    store(b, (p, 2), load(b, (p, 2)) + fz)
    store(b, (q, 0), load(b, (q, 0)) - fx)
    store(b, (q, 1), load(b, (q, 1)) - fy)
    store(b, (q, 2), load(b, (q, 2)) - fz)
    t = h * h * maximum(load(T, (p, offset - 1)), 0.0) * inverse
    s = h * h * k * inverse_rest - t
    xx, xy, xz = s * dx * dx + t, s * dx * dy, s * dx * dz
    yy, yz, zz = s * dy * dy + t, s * dy * dz, s * dz * dz + t
    add_diagonal(A, p, xx, xy, xz, yy, yz, zz)
    add_diagonal(A, q, xx, xy, xz, yy, yz, zz)
    add_coupling(A, p, offset, -xx, -xy, -xz, -yy, -yz, -zz)


@njit(cache=True)
def multiplier(x, dx, p, offset, k, inverse_rest):  # noqa: ANN001, ANN201
    """Tension that the linear system gave a spring: k (d . (x_q + dx_q - x_p - dx_p) / l0 - 1) [N].

    x   where the system was linearised [m]; dx  what it was moved by [m]; both (particles, 3, WIDTH)
    """
    q = p + offset
    ux, uy, uz, inverse = _direction(x, p, q)
    along = (
        ux * (load(dx, (q, 0)) - load(dx, (p, 0)))
        + uy * (load(dx, (q, 1)) - load(dx, (p, 1)))
        + uz * (load(dx, (q, 2)) - load(dx, (p, 2)))
    )
    return k * (inverse_rest * (1.0 / inverse + along) - 1.0)
