"""The nearest positive semidefinite matrix to that of a vertex, for solves whose result is wrong with the exact one.

Eigenvalues of 8 x 8 matrices by Jacobi's cyclic rotations, one matrix per lane; negative ones are set to zero. It
costs as much as ten ordinary segments, and is rare.

Source: Golub and Van Loan, Matrix Computations, Sec. 8.5.
"""

from numba import njit

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import load, local_rows, maximum, select, sqrt, store
from hairpipe.sim.strands.rod.vertex import Tangent

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
