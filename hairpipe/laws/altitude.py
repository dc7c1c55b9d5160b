"""Altitude springs: Sec. 3.1 of Selle, Lentine, Fedkiw 2008, without a branch.

For four particles let N_i be the gradient of six times their volume with respect to particle i. The seven candidates
are the four N_i (point against face) and N_1+N_2, N_1+N_3, N_2+N_3 (edge against edge). The one with the largest |N| is
the shortest, h = 6V / |N|, and only it acts, along n = N / |N| with weights g_i = N_i . N / |N|^2:

    f_i = -k (h / h0 - 1) g_i n,   K_ij = (k / |h0|) g_i g_j n n^T

h and its rest value h0 are signed, so an inverted tetrahedron is pushed back through zero. dh/dx_i = g_i n exactly, the
weights being those of the nearest points, so the force is the gradient of k/2 (h - h0)^2 / h0; K leaves out the
change of n. When the choice changes, h is continuous, but h0, g and n are not: this jump is part of the model.

Four particles on a line have no N, see `laws/altitude.py`. Four in one place get no force.

We differ from the paper, where no altitude spring acts on a collapsed edge: its direction is well defined, that of the
remaining face, and no spring has to be switched off.

Four particles on a line, whose altitude has no direction: the last resort of Sec. 3.1.

The second and the third are displaced by a tiny fraction of the extent, in directions that depend only on the line.
The shortest altitude of the resulting tetrahedron is chosen as usual: its length is nearly 0, its direction normal to
the line, and its weights are valid, so the full force of the spring moves the particles off the line. The displacement
fades in where rounding begins to blur the true direction, without a jump.

We differ from the paper and its code, which ignore the true direction below an angle of 7.6 degrees and then measure
only the overlap of two edges. The losses: the side from which the particles came to the line is not stored, the
direction changes abruptly as the line passes a diagonal of the axes, and angular momentum is conserved only up to the
size of the displacement.
"""
# pyright: reportCallIssue=false

from numba import njit

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import any_lane, by_precision, difference, load, maximum, minimum, select, sqrt
from hairpipe.geometry.sym3 import outer
from hairpipe.geometry.vec3 import cross, dot, plus, scaled


@inlined
def nothing(x):
    """Return a tiny positive number of the lanes' precision [1]."""
    return by_precision(x, 1e-200, 1e-36)


@inlined
def _limit(u, v, w):
    """Value of |N|^2 below which particles are collinear."""
    extent = dot(u, u) + dot(v, v) + dot(w, w)
    return by_precision(extent, 1e-16, 1e-9) * extent * extent


@inlined
def collinear(u, v, w, size):
    """Particles so close to a line that their altitude is lost in rounding."""
    return size < _limit(u, v, w)


@inlined
def off_the_line(u, v, w, size, where):
    """Return u and v [m], displaced where the particles are collinear."""
    along = _longer(u, _longer(v, w))
    aside = cross(along, _least_axis(along))
    limit = maximum(_limit(u, v, w), nothing(size))
    # The last factor is 0 at the limit: the displacement fades in, and the force does not jump there.
    reach = by_precision(size, 2e-8, 1e-4) * sqrt(dot(along, along)) * (1.0 - size / limit)
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


@inlined
def _larger(best, candidate, rest):
    """Keep the candidate with the larger |N|^2; the earlier one wins a tie."""
    size, (x, y, z), kept = best
    s = dot(candidate, candidate)
    m = s > size
    chosen = select(m, candidate[0], x), select(m, candidate[1], y), select(m, candidate[2], z)
    return select(m, s, size), chosen, select(m, rest, kept)


@inlined
def area_vectors(u, v, w):
    """N_0 ... N_3 [m^2] of the particles a, a + u, a + v, a + w; tuples of three lanes [m]."""
    n1, n2, n3 = cross(v, w), cross(w, u), cross(u, v)
    return (-(n1[0] + n2[0] + n3[0]), -(n1[1] + n2[1] + n3[1]), -(n1[2] + n2[2] + n3[2])), n1, n2, n3


@inlined
def altitude_along(areas, chosen, size, u):
    """Weights g, direction n and signed height h [m] of one altitude: (g_0, g_1, g_2, g_3), (n_x, n_y, n_z), h.

    areas  N_0 ... N_3; chosen  N of this altitude; size  |N|^2 [m^4]; u  from particle 0 to 1 [m]
    """
    inverse = 1.0 / maximum(size, nothing(size))  # Four particles in one place have no N: force 0 instead of NaN.
    n0, n1, n2, n3 = areas
    weights = dot(n0, chosen) * inverse, dot(n1, chosen) * inverse, dot(n2, chosen) * inverse, dot(n3, chosen) * inverse
    length = sqrt(inverse)
    return weights, scaled(length, chosen), dot(n1, u) * length


@inlined
def _shortest(u, v, w, rest):
    """Area vectors, the largest |N|^2 of the candidates, their N, and what `rest` holds for it."""
    n0, n1, n2, n3 = area_vectors(u, v, w)
    best = dot(n0, n0), n0, rest[0]  # 6V is common to all: the shortest has the largest |N|; nothing is divided.
    best = _larger(best, n1, rest[1])
    best = _larger(best, n2, rest[2])
    best = _larger(best, n3, rest[3])
    best = _larger(best, plus(n1, n2), rest[4])
    best = _larger(best, plus(n1, n3), rest[5])
    return (n0, n1, n2, n3), _larger(best, plus(n2, n3), rest[6])


@njit(cache=True, error_model="numpy", _nrt=False)
def _shortest_off_the_line(u, v, w, rest, size, thin):
    """Choose for particles on a line, as _shortest; not copied into the loop, since it is rare and long."""
    u, v = off_the_line(u, v, w, size, thin)
    areas, best = _shortest(u, v, w, rest)
    return areas, best, u


@inlined
def shortest_altitude(u, v, w, rest):
    """Weights, direction and height of the altitude that acts, as in altitude_along, and what `rest` holds for it.

    u, v, w  from particle 0 to the others [m], tuples of three lanes
    rest     one value for each of the seven candidates, a tuple of seven lanes
    """
    areas, best = _shortest(u, v, w, rest)
    thin = collinear(u, v, w, best[0])
    if any_lane(thin):  # A branch for the whole block: it is rare that any of its lanes needs this.
        areas, best, u = _shortest_off_the_line(u, v, w, rest, best[0], thin)
    size, chosen, kept = best
    weights, direction, height = altitude_along(areas, chosen, size, u)
    return weights, direction, height, kept


@inlined
def _candidates(values, p):
    first = load(values, (p, 0)), load(values, (p, 1)), load(values, (p, 2)), load(values, (p, 3))
    return (*first, load(values, (p, 4)), load(values, (p, 5)), load(values, (p, 6)))


@inlined
def linearise_altitude(x, p, k, inverse_heights, h, hh):
    """Return weights g_0 ... g_3, h f and hh K of the tetrahedron of particles p to p + 3.

    Particle i feels g_i h f, and particles i and j are coupled by g_i g_j hh K.

    x                positions [m], (particles, 3, W)
    k                force per unit strain [N]
    inverse_heights  signed 1 / h0 of the seven candidates [1/m], 0 where none acts, (particles, 7, W)
    h                step [s]; hh  its square, or 0 for a spring that is not implicit [s^2]
    """
    u, v, w = difference(x, p, p + 1), difference(x, p, p + 2), difference(x, p, p + 3)
    weights, n, height, inverse_rest = shortest_altitude(u, v, w, _candidates(inverse_heights, p))
    f = -h * k * (height * inverse_rest - 1.0)
    # A force on the strain h / h0 - 1: its sign follows the rest height, its stiffness does not.
    f = select(inverse_rest > 0.0, f, select(inverse_rest < 0.0, -f, 0.0))
    return weights, scaled(f, n), outer(hh * k * maximum(inverse_rest, -inverse_rest), n)
