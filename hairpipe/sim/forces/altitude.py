"""Altitude springs: Sec. 3.1 of Selle, Lentine, Fedkiw 2008, without a branch.

For four particles let N_i be the gradient of six times their volume with respect to particle i. The seven candidates
are the four N_i (point against face) and N_1+N_2, N_1+N_3, N_2+N_3 (edge against edge). The one with the largest |N| is
the shortest, h = 6V / |N|, and only it acts, along n = N / |N| with weights g_i = N_i . N / |N|^2:

    f_i = -k (h / h0 - 1) g_i n,   K_ij = (k / |h0|) g_i g_j n n^T

h and its rest value h0 are signed, so an inverted tetrahedron is pushed back through zero. dh/dx_i = g_i n exactly, the
weights being those of the nearest points, so the force is the gradient of k/2 (h - h0)^2 / h0; K leaves out the
change of n. Four particles on a line have no N and get no force.
"""

from numba import njit

from hairpipe.sim.banded import add_coupling, add_diagonal
from hairpipe.sim.lanes import load, maximum, select, sqrt, store

_SMALLEST = 1e-30  # [m^4]; |N|^2 below this means that the particles are collinear


@njit(cache=True)
def _area(ux, uy, uz, vx, vy, vz):  # noqa: ANN001, ANN202
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@njit(cache=True)
def _larger(best, x, y, z, inverse_rest):  # noqa: ANN001, ANN202
    """Keep the candidate with the larger |N|^2; the earlier one wins a tie."""
    size, bx, by, bz, b_rest = best
    s = x * x + y * y + z * z
    m = s > size
    return select(m, s, size), select(m, x, bx), select(m, y, by), select(m, z, bz), select(m, inverse_rest, b_rest)


@njit(cache=True)
def add_altitude(A, b, x, p, k, inverse_heights, h):  # noqa: ANN001, ANN201
    """Add h f to b and h^2 K to A for the tetrahedron of particles p to p + 3, in place.

    x                positions [m], (particles, 3, WIDTH)
    k                force per unit strain [N]
    inverse_heights  signed 1 / h0 of the seven candidates [1/m], (particles, 7, WIDTH)
    h                step [s]
    """
    ax, ay, az = load(x, (p, 0)), load(x, (p, 1)), load(x, (p, 2))
    ux, uy, uz = load(x, (p + 1, 0)) - ax, load(x, (p + 1, 1)) - ay, load(x, (p + 1, 2)) - az
    vx, vy, vz = load(x, (p + 2, 0)) - ax, load(x, (p + 2, 1)) - ay, load(x, (p + 2, 2)) - az
    wx, wy, wz = load(x, (p + 3, 0)) - ax, load(x, (p + 3, 1)) - ay, load(x, (p + 3, 2)) - az
    n1x, n1y, n1z = _area(vx, vy, vz, wx, wy, wz)
    n2x, n2y, n2z = _area(wx, wy, wz, ux, uy, uz)
    n3x, n3y, n3z = _area(ux, uy, uz, vx, vy, vz)
    n0x, n0y, n0z = -(n1x + n2x + n3x), -(n1y + n2y + n3y), -(n1z + n2z + n3z)

    size = n0x * n0x + n0y * n0y + n0z * n0z
    best = size, n0x, n0y, n0z, load(inverse_heights, (p, 0))
    best = _larger(best, n1x, n1y, n1z, load(inverse_heights, (p, 1)))
    best = _larger(best, n2x, n2y, n2z, load(inverse_heights, (p, 2)))
    best = _larger(best, n3x, n3y, n3z, load(inverse_heights, (p, 3)))
    best = _larger(best, n1x + n2x, n1y + n2y, n1z + n2z, load(inverse_heights, (p, 4)))
    best = _larger(best, n1x + n3x, n1y + n3y, n1z + n3z, load(inverse_heights, (p, 5)))
    best = _larger(best, n2x + n3x, n2y + n3y, n2z + n3z, load(inverse_heights, (p, 6)))
    size, nx, ny, nz, inverse_rest = best

    collinear = size < _SMALLEST
    size = maximum(size, _SMALLEST)
    inverse = 1.0 / sqrt(size)
    g0 = (n0x * nx + n0y * ny + n0z * nz) / size
    g1 = (n1x * nx + n1y * ny + n1z * nz) / size
    g2 = (n2x * nx + n2y * ny + n2z * nz) / size
    g3 = (n3x * nx + n3y * ny + n3z * nz) / size
    height = (n1x * ux + n1y * uy + n1z * uz) * inverse
    nx, ny, nz = nx * inverse, ny * inverse, nz * inverse

    f = select(collinear, 0.0, -h * k * (height * inverse_rest - 1.0))
    # A force on the strain h / h0 - 1: its sign follows the rest height, its stiffness does not.
    f = select(inverse_rest < 0.0, -f, f)
    s = select(collinear, 0.0, h * h * k * maximum(inverse_rest, -inverse_rest))
    _scatter(A, b, p, 0, g0, g0, g1, g2, g3, f, s, nx, ny, nz)
    _scatter(A, b, p, 1, g1, g0, g1, g2, g3, f, s, nx, ny, nz)
    _scatter(A, b, p, 2, g2, g0, g1, g2, g3, f, s, nx, ny, nz)
    _scatter(A, b, p, 3, g3, g0, g1, g2, g3, f, s, nx, ny, nz)


@njit(cache=True)
def _scatter(A, b, p, i, g, g0, g1, g2, g3, f, s, nx, ny, nz):  # noqa: ANN001, ANN202
    """Add the force on particle p + i and its blocks with itself and the particles after it."""
    fx = f * g
    store(b, (p + i, 0), load(b, (p + i, 0)) + fx * nx)
    store(b, (p + i, 1), load(b, (p + i, 1)) + fx * ny)
    store(b, (p + i, 2), load(b, (p + i, 2)) + fx * nz)
    sx, sy, sz = s * g * nx, s * g * ny, s * g * nz
    xx, xy, xz, yy, yz, zz = sx * nx, sx * ny, sx * nz, sy * ny, sy * nz, sz * nz
    add_diagonal(A, p + i, g * xx, g * xy, g * xz, g * yy, g * yz, g * zz)
    if i < 1:
        add_coupling(A, p + i, 1 - i, g1 * xx, g1 * xy, g1 * xz, g1 * yy, g1 * yz, g1 * zz)
    if i < 2:
        add_coupling(A, p + i, 2 - i, g2 * xx, g2 * xy, g2 * xz, g2 * yy, g2 * yz, g2 * zz)
    if i < 3:
        add_coupling(A, p + i, 3 - i, g3 * xx, g3 * xy, g3 * xz, g3 * yy, g3 * yz, g3 * zz)
