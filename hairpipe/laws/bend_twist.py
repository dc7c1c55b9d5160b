"""Curvature and twist at a vertex of a discrete elastic rod, with their first and second derivatives in closed form.

Between an edge e and the next one f, with unit tangents te, tf and material directors m1, m2 = t x m1 on each,

    kb = 2 te x tf / chi,   chi = 1 + te . tf,   tt = (te + tf) / chi,   c1 = (m1e + m1f) / chi,   c2 likewise
    k1 = (m2e + m2f) . kb / 2,   k2 = -(m1e + m1f) . kb / 2
    psi = twist from the frame of e, transported over the vertex without twist, to that of f

and with the frames transported as edges rotate, and rotated about them by th,

    dk1/de = (-k1 tt + tf x c2) / |e|     dk1/df = (-k1 tt - te x c2) / |f|     dk1/dth = -m1 . kb / 2
    dk2/de = (-k2 tt - tf x c1) / |e|     dk2/df = (-k2 tt + te x c1) / |f|     dk2/dth = -m2 . kb / 2
    dpsi/de = kb / (2 |e|)                dpsi/df = kb / (2 |f|)                dpsi/dth = -1, +1

of each edge. The energy B1/2 (k1 - k1')^2 + B1/2 (k2 - k2')^2 + C1/2 (psi - psi')^2 has the moments q1, q2, q3,
the gradient sum q g and the second derivative sum B g g^T + sum q ddk, all in the eight variables (e, th_e, f, th_f),
which are linear in the nodes. Second derivatives of both curvatures are summed before they are expanded, by D = q1 c2
- q2 c1 and K = q1 k1 + q2 k2.

Source: Bergou, Audoly, Vouga, Wardetzky, Grinspun, Discrete Viscous Threads, 2010.

The nearest positive semidefinite matrix to that of a vertex, for solves whose result is wrong with the exact one.

Eigenvalues of 8 x 8 matrices by Jacobi's cyclic rotations, one matrix per lane; negative ones are set to zero. It
costs as much as ten ordinary segments, and is rare.

Source: Golub and Van Loan, Matrix Computations, Sec. 8.5.
"""
# pyright: reportCallIssue=false

from typing import Any, NamedTuple

from numba import njit

from hairpipe.geometry import sym3
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.frames import FOLDED
from hairpipe.geometry.simd import load, local_rows, maximum, select, sqrt, store
from hairpipe.geometry.vec3 import cross, dot, minus, plus, scaled


class Tangent(NamedTuple):
    """A symmetric matrix in (e, th_e, f, th_f), by blocks: sixes are symmetric, nines row by row, e before f."""

    ee: Any
    ef: Any
    ff: Any
    e_a: Any
    e_b: Any
    f_a: Any
    f_b: Any
    aa: Any
    ab: Any
    bb: Any


class Gradient(NamedTuple):
    """Derivatives by e, f [1/m] and by the angles of both edges."""

    e: Any
    f: Any
    a: Any
    b: Any


class Bend(NamedTuple):
    """A vertex: unit tangents, 1 / length of the edges [1/m], directors, and what the module names."""

    te: Any
    tf: Any
    ie: Any
    jf: Any
    m1e: Any
    m1f: Any
    m2e: Any
    m2f: Any
    inverse: Any
    kb: Any
    tt: Any
    c1: Any
    c2: Any
    k1: Any
    k2: Any


@inlined
def bend(te, tf, ie, jf, m1e, m1f):
    """Measure a vertex between unit tangents te and tf with directors m1e and m1f; ie, jf  1 / lengths [1/m]."""
    m2e, m2f = cross(te, m1e), cross(tf, m1f)
    inverse = 1.0 / maximum(1.0 + dot(te, tf), FOLDED)  # Beyond `FOLDED` the curvature grows no further.
    kb = scaled(2.0 * inverse, cross(te, tf))
    m1, m2 = plus(m1e, m1f), plus(m2e, m2f)
    k1, k2 = 0.5 * dot(m2, kb), -0.5 * dot(m1, kb)
    tt = scaled(inverse, plus(te, tf))
    c1 = scaled(inverse, m1)
    c2 = scaled(inverse, m2)
    return Bend(te, tf, ie, jf, m1e, m1f, m2e, m2f, inverse, kb, tt, c1, c2, k1, k2)


@inlined
def gradients(v):
    """Return the derivatives of k1, k2 and psi at a vertex."""
    tf_c2, te_c2, tf_c1, te_c1 = cross(v.tf, v.c2), cross(v.te, v.c2), cross(v.tf, v.c1), cross(v.te, v.c1)
    bent1 = scaled(v.k1, v.tt)
    bent2 = scaled(v.k2, v.tt)
    half = scaled(0.5, v.kb)
    first = Gradient(
        scaled(v.ie, minus(tf_c2, bent1)),
        scaled(-v.jf, plus(te_c2, bent1)),
        -dot(v.m1e, half),
        -dot(v.m1f, half),
    )
    second = Gradient(
        scaled(-v.ie, plus(tf_c1, bent2)),
        scaled(v.jf, minus(te_c1, bent2)),
        -dot(v.m2e, half),
        -dot(v.m2f, half),
    )
    zero = 0.0 * v.k1
    return first, second, Gradient(scaled(v.ie, half), scaled(v.jf, half), zero - 1.0, zero + 1.0)


@inlined
def force_of(q, g):
    """Return the gradient of the energy: the sum of the moments q times the gradients g of three measures."""
    (q1, q2, q3), (g1, g2, g3) = q, g
    e = plus(plus(scaled(q1, g1.e), scaled(q2, g2.e)), scaled(q3, g3.e))
    f = plus(plus(scaled(q1, g1.f), scaled(q2, g2.f)), scaled(q3, g3.f))
    return Gradient(e, f, q1 * g1.a + q2 * g2.a - q3, q1 * g1.b + q2 * g2.b + q3)


@inlined
def _product(a, b):
    """a b^T, row by row."""
    x, y, z = scaled(a[0], b), scaled(a[1], b), scaled(a[2], b)
    return x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]


@inlined
def _sum9(A, B):
    x, y, z = plus(A[0:3], B[0:3]), plus(A[3:6], B[3:6]), plus(A[6:9], B[6:9])
    return x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]


@inlined
def _both(a, b):
    """a b^T + b a^T."""
    xx, yy, zz = a[0] * b[0], a[1] * b[1], a[2] * b[2]
    xy, xz, yz = a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[2] * b[0], a[1] * b[2] + a[2] * b[1]
    return xx + xx, xy, xz, yy + yy, yz, zz + zz


@inlined
def stretch_of(s, g):
    """Return s g g^T of one measure."""
    e, f = scaled(s, g.e), scaled(s, g.f)
    return Tangent(
        sym3.outer(s, g.e),
        _product(e, g.f),
        sym3.outer(s, g.f),
        scaled(g.a, e),
        scaled(g.b, e),
        scaled(g.a, f),
        scaled(g.b, f),
        s * g.a * g.a,
        s * g.a * g.b,
        s * g.b * g.b,
    )


@inlined
def sum_of(A, B):
    """Add two tangents."""
    return Tangent(
        sym3.plus(A.ee, B.ee),
        _sum9(A.ef, B.ef),
        sym3.plus(A.ff, B.ff),
        plus(A.e_a, B.e_a),
        plus(A.e_b, B.e_b),
        plus(A.f_a, B.f_a),
        plus(A.f_b, B.f_b),
        A.aa + B.aa,
        A.ab + B.ab,
        A.bb + B.bb,
    )


@inlined
def _across(s, K, t):
    """s times its transverse part: - K (1 - t t^T)."""
    n = sym3.outer(s * K, t)
    k = s * K
    return n[0] - k, n[1], n[2], n[3] - k, n[4], n[5] - k


@inlined
def _of_edge(s, v, K, side, moment, t):
    """Second derivative by one edge, times |edge|^2 = 1 / s^2: see the source."""
    leading = sym3.plus(_both(scaled(s * s, v.tt), side), _both(scaled(0.25 * s * s, v.kb), moment))
    return sym3.plus(leading, _across(s * s, K * v.inverse, t))


@inlined
def geometric(q, v):
    """Return the part of the tangent by which moments turn with the rod: the sum of q times second derivatives."""
    q1, q2, q3 = q
    K = q1 * v.k1 + q2 * v.k2
    D = minus(scaled(q1, v.c2), scaled(q2, v.c1))
    d_e, d_f = minus(scaled(q1, v.m2e), scaled(q2, v.m1e)), minus(scaled(q1, v.m2f), scaled(q2, v.m1f))
    c_e, c_f = plus(scaled(q1, v.m1e), scaled(q2, v.m2e)), plus(scaled(q1, v.m1f), scaled(q2, v.m2f))
    bent = scaled(K, v.tt)
    twisted = scaled(0.25 * q3, v.kb)
    te_D = plus(bent, cross(v.te, D))
    tf_D = minus(bent, cross(v.tf, D))
    ee = _of_edge(v.ie, v, K, minus(tf_D, twisted), minus(d_e, scaled(q3, v.te)), v.te)
    ff = _of_edge(v.jf, v, K, minus(te_D, twisted), minus(d_f, scaled(q3, v.tf)), v.tf)
    s = v.ie * v.jf
    k = s * K * v.inverse
    ef = _sum9(_product(scaled(s, v.tt), te_D), _product(scaled(s, minus(tf_D, plus(twisted, twisted))), v.tt))
    ef = _sum9(ef, _product(scaled(-k, v.te), v.tf))
    w = scaled(s, minus(scaled(q3 * v.inverse, v.te), D))
    ef = (
        ef[0] - k,
        ef[1] - w[2],
        ef[2] + w[1],
        ef[3] + w[2],
        ef[4] - k,
        ef[5] - w[0],
        ef[6] - w[1],
        ef[7] + w[0],
        ef[8] - k,
    )
    half = scaled(0.5, v.kb)
    n_e = scaled(v.inverse, v.tf)
    n_f = scaled(v.inverse, v.te)
    along_e, along_f = scaled(dot(half, c_e), v.tt), scaled(dot(half, c_f), v.tt)
    return Tangent(
        ee,
        ef,
        ff,
        scaled(v.ie, minus(along_e, cross(n_e, c_e))),
        scaled(v.ie, minus(along_f, cross(n_e, c_f))),
        scaled(v.jf, plus(along_e, cross(n_f, c_e))),
        scaled(v.jf, plus(along_f, cross(n_f, c_f))),
        -dot(half, d_e),
        0.0 * k,
        -dot(half, d_f),
    )


SIZE = 8
_SWEEPS = 7
_E, _A, _F, _B = 0, 3, 4, 7
"""Places of e, th_e, f and th_f in the matrix."""


@njit(cache=True, error_model="numpy", _nrt=False)
def semidefinite(H, like):
    """Return the tangent H of a vertex without its negative eigenvalues; like  an array of its lanes, (..., W)."""
    S, V = local_rows(64, like), local_rows(64, like)
    _write(H, S)
    for i in range(SIZE):
        for j in range(SIZE):
            store(V, (8 * i + j,), 1.0 if i == j else 0.0)
    for _ in range(_SWEEPS):  # A fixed number: a test of convergence would let lanes of a block depend on each other.
        for i in range(SIZE - 1):
            for j in range(i + 1, SIZE):
                _rotate(S, V, i, j)
    _recompose(S, V)
    return _read(S)


@inlined
def _rotate(S, V, i, j):
    """Rotate rows and columns i and j so that S_ij becomes zero."""
    a, b, c = load(S, (8 * i + i,)), load(S, (8 * j + j,)), load(S, (8 * i + j,))
    size = sqrt((b - a) * (b - a) + 4.0 * c * c)
    bottom = select(b > a, b - a + size, b - a - size)  # The smaller rotation; this sign avoids cancellation.
    t = select(bottom * bottom > 0.0, 2.0 * c / bottom, 0.0)
    cosine = 1.0 / sqrt(1.0 + t * t)
    sine = t * cosine
    for k in range(SIZE):
        _turn(S, 8 * k + i, 8 * k + j, sine, cosine)
        _turn(V, 8 * k + i, 8 * k + j, sine, cosine)
    for k in range(SIZE):
        _turn(S, 8 * i + k, 8 * j + k, sine, cosine)


@inlined
def _turn(M, here, there, sine, cosine):
    a, b = load(M, (here,)), load(M, (there,))
    store(M, (here,), cosine * a - sine * b)
    store(M, (there,), sine * a + cosine * b)


@inlined
def _recompose(S, V):
    """Set the upper half of S to V max(S, 0) V^T, of its diagonal; V is lost."""
    for k in range(SIZE):
        # Square roots on both sides, so that V S V^T needs one array; negative eigenvalues become 0 here.
        size = sqrt(maximum(load(S, (8 * k + k,)), 0.0))
        for i in range(SIZE):
            store(V, (8 * i + k,), size * load(V, (8 * i + k,)))
    for i in range(SIZE):
        for j in range(i, SIZE):
            total = load(V, (8 * i + 0,)) * load(V, (8 * j + 0,))
            for k in range(1, SIZE):
                total = total + load(V, (8 * i + k,)) * load(V, (8 * j + k,))
            store(S, (8 * i + j,), total)


@inlined
def _write_six(S, i, six):
    store(S, (8 * i + i,), six[0])
    store(S, (8 * (i + 1) + i + 1,), six[3])
    store(S, (8 * (i + 2) + i + 2,), six[5])
    _write_pair(S, i, i + 1, six[1])
    _write_pair(S, i, i + 2, six[2])
    _write_pair(S, i + 1, i + 2, six[4])


@inlined
def _write_pair(S, i, j, value):
    store(S, (8 * i + j,), value)
    store(S, (8 * j + i,), value)


@inlined
def _write(H, S):
    _write_six(S, _E, H.ee)
    _write_six(S, _F, H.ff)
    for c in range(3):
        _write_pair(S, _E + c, _A, H.e_a[c])
        _write_pair(S, _E + c, _B, H.e_b[c])
        _write_pair(S, _F + c, _A, H.f_a[c])
        _write_pair(S, _F + c, _B, H.f_b[c])
    for c in range(9):
        _write_pair(S, _E + c // 3, _F + c % 3, H.ef[c])
    store(S, (8 * _A + _A,), H.aa)
    _write_pair(S, _A, _B, H.ab)
    store(S, (8 * _B + _B,), H.bb)


@inlined
def _read_six(S, i):
    first = load(S, (8 * i + i,)), load(S, (8 * i + i + 1,)), load(S, (8 * i + i + 2,))
    return (*first, load(S, (8 * (i + 1) + i + 1,)), load(S, (8 * (i + 1) + i + 2,)), load(S, (8 * (i + 2) + i + 2,)))


@inlined
def _read_column(S, i, j):
    """Three numbers of a column from row i on; of the upper half."""
    return load(S, (8 * i + j,)), load(S, (8 * (i + 1) + j,)), load(S, (8 * (i + 2) + j,))


@inlined
def _read_row(S, i, j):
    return load(S, (8 * i + j,)), load(S, (8 * i + j + 1,)), load(S, (8 * i + j + 2,))


@inlined
def _read(S):
    x, y, z = _read_row(S, 0, _F), _read_row(S, 1, _F), _read_row(S, 2, _F)
    return Tangent(
        _read_six(S, _E),
        (x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]),
        _read_six(S, _F),
        _read_column(S, _E, _A),
        _read_column(S, _E, _B),
        _read_row(S, _A, _F),
        _read_column(S, _F, _B),
        load(S, (8 * _A + _A,)),
        load(S, (8 * _A + _B,)),
        load(S, (8 * _B + _B,)),
    )
