"""The network of a curl, fitted to the compliance of a rod of the same shape.

Springs are calibrated on a straight strand, and their transverse stiffness is anisotropic, which averages out as the
lattice turns. On a curl of few segments per turn it does not: the stiffness depends on the roll of the lattice and on
its first sense of rotation. So each curl gets the lattice, of `ROLLS` rolls and both senses, whose tip compliance is
closest to that of the rod up to a factor, and this factor scales its springs so that both agree on average. With C the
compliance of the tip of the network, and C^ that of the rod, both (3, 3),

    factor = tr(C^-1 C) / 3,    chosen: least |C^-1 C / factor - 1|.

Forces are small, so C^ is a sum over the points of a strand (Castigliano): with r the vector from a point to the tip,
t the tangent there and l its share of the arc,

    C^ = sum l [r]x^T ((I - t t^T) / EI + t t^T / GJ) [r]x + sum l t t^T / EA.

The arc between two points is that of a circle. A strand counts as curled if it bends by more than `STRAIGHTEST` per
point, on average: below this the effect of the lattice is less than half a percent, and hair that only bends to its
groomed direction, or sags, is not a curl. Not in the paper.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.kernels.vec3 import cross, dot, minus, plus, row, scaled
from hairpipe.sim.material import Material
from hairpipe.sim.strands import lattice
from hairpipe.sim.strands.fibres import Section, taken

ROLLS = 6
"""Number of tried angles over a whole turn."""
STRAIGHTEST = np.deg2rad(5.0)
"""Mean bend at a point of a strand that has no curl, at most [rad]."""
_AT_ONCE = 1024
"""Strands, for the sake of memory."""
_BAND = 3 * 3 + 3
"""Numbers of a row of the stiffness, from the diagonal on: a force couples a particle to three after it."""
_ALIKE = 1e-6
"""Differences that say nothing: the first of two such lattices is taken."""


class Fit(NamedTuple):
    """Lattices and spring factors of curls.

    normals  initial directions of the lattices, (s, 3)
    turns    turns of the lattices from segment to segment [rad], (s, 1)
    factors  factors on the constants of all springs except edges, (s,)
    """

    normals: np.ndarray
    turns: np.ndarray
    factors: np.ndarray


def fit_curls(axis: np.ndarray, normals: np.ndarray, turn: float, constants: np.ndarray, section: Section) -> Fit:
    """Choose the lattice of every strand, and a factor on its springs; straight strands keep theirs, and get 1. Pure.

    axis       points of strands of n segments [m], (s, n+1, 3)
    normals    normals of the first segments, see `lattice.first_normals`, (s, 3)
    turn       turn of the lattice [rad]
    constants  see `constants_by_particle` of the network [N], (s, p, 4)
    section    of the fibre at the points, (s, n+1)
    """
    fit = Fit(normals.copy(), np.full((len(axis), 1), turn), np.ones(len(axis)))
    bends = _bends(axis)
    curled = np.flatnonzero(bends.sum(1) > STRAIGHTEST * max(bends.shape[1], 1))
    for some in np.split(curled, range(_AT_ONCE, len(curled), _AT_ONCE)):
        if len(some):
            chosen = _fit_some(axis[some], normals[some], turn, constants[some], taken(section, some))
            for whole, part in zip(fit, chosen, strict=True):
                whole[some] = part
    return fit


def _fit_some(axis: np.ndarray, normals: np.ndarray, turn: float, constants: np.ndarray, section: Section) -> Fit:
    """Try lattice after lattice on strands that are curled; arguments as for `fit_curls`."""
    soft = tip_of_rod(axis, constants[:, 2:-1:2, 0], section)
    edges = axis[:, 1] - axis[:, 0]
    aside = np.cross(edges / np.linalg.norm(edges, axis=1, keepdims=True), normals)
    best = Fit(normals.copy(), np.full((len(axis), 1), turn), np.ones(len(axis)))
    least = np.full(len(axis), np.inf)
    for roll in 2.0 * np.pi * np.arange(ROLLS) / ROLLS:
        first = np.cos(roll) * normals + np.sin(roll) * aside
        for sense in (turn, -turn):
            ratio = tip_of_network(lattice.perturb(axis, first, sense), constants)
            # The same as C^-1 C, in coordinates in which that is symmetric.
            ratio = _inverse(soft.transpose(0, 2, 1) @ ratio @ soft)
            factors = np.trace(ratio, axis1=1, axis2=2) / 3.0
            unlike = np.linalg.norm(ratio / factors[:, None, None] - np.eye(3), axis=(1, 2))
            better = unlike < least - _ALIKE
            least[better] = unlike[better]
            best.normals[better], best.turns[better], best.factors[better] = first[better], sense, factors[better]
    return best


def _bends(axis: np.ndarray) -> np.ndarray:
    """Angles by which strands bend at their inner points [rad], (s, n-1)."""
    edges = np.diff(axis, axis=1)
    edges = edges / np.linalg.norm(edges, axis=2, keepdims=True)
    return 2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(np.diff(edges, axis=1), axis=2), 1.0))


def _inverse(matrices: np.ndarray) -> np.ndarray:
    """Invert symmetric matrices, (s, 3, 3), without LAPACK, whose threads cost more than that is."""
    a, b, c = np.moveaxis(matrices, 1, 0)
    adjugate = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    return adjugate / np.sum(a * adjugate[:, 0], axis=1)[:, None, None]


def tip_of_rod(axis: np.ndarray, axial: np.ndarray, section: Section | Material) -> np.ndarray:
    """Return L of the compliance of the tip of rods, C^ = L L^T [m/N], (s, 3, 3).

    axis     [m], (s, n+1, 3)
    axial    EA of the segments [N], (s, n)
    section  of the fibre at the points
    """
    edges = np.diff(axis, axis=1)
    lengths = np.linalg.norm(edges, axis=2)
    along = edges / lengths[:, :, None]
    half = 0.5 * _bends(axis)
    # A point has half the arc before it and half that behind it; the arcs at both ends bend as their neighbours do.
    arc = lengths / np.sinc(np.concatenate([half[:, :1], 0.5 * (half[:, 1:] + half[:, :-1]), half[:, -1:]], 1) / np.pi)
    tangents = np.concatenate([along[:, :1], along[:, 1:] + along[:, :-1], along[:, -1:]], axis=1)
    tangents /= np.linalg.norm(tangents, axis=2, keepdims=True)
    bending, torsion = (np.broadcast_to(of, axis.shape[:2]) for of in (section.bending, section.torsion))
    axial = np.broadcast_to(axial, lengths.shape)
    total = np.zeros((len(axis), 3, 3))
    for k in range(edges.shape[1]):
        share = 0.5 * (arc[:, k] + (arc[:, k - 1] if k > 0 else 0.0))
        couples = np.cross((axis[:, -1] - axis[:, k])[:, None], np.eye(3))
        twists = np.einsum("sci,si->sc", couples, tangents[:, k])
        bent = couples @ couples.transpose(0, 2, 1) / bending[:, k, None, None]
        softer = (1.0 / torsion[:, k] - 1.0 / bending[:, k])[:, None, None]
        twisted = softer * twists[:, :, None] * twists[:, None, :]
        total += share[:, None, None] * (bent + twisted)
        total += (arc[:, k] / axial[:, k])[:, None, None] * along[:, k, :, None] * along[:, k, None, :]
    return np.linalg.cholesky(total)


def tip_of_network(particles: np.ndarray, constants: np.ndarray) -> np.ndarray:
    """Return the stiffness of the tip of networks at rest, with all particles except the clamp free [N/m], (s, 3, 3).

    particles  [m], (s, p, 3); constants  see `fit_curls`
    """
    found = np.empty((len(particles), 3, 3))
    _tips(particles, np.ascontiguousarray(constants), found)
    return found


@njit(cache=True, parallel=True)
def _tips(particles, constants, out):
    for s in prange(len(particles)):
        _tip(particles[s], constants[s], out[s])


@njit(cache=True)
def _tip(x, constants, out):
    """Eliminate all free particles but the last: what is left is the stiffness of that one."""
    count = len(x)
    A = np.zeros((3 * count, _BAND))
    for p in range(count - 1):
        for offset in range(1, min(4, count - p)):
            d = minus(row(x, p + offset), row(x, p))
            length = np.sqrt(dot(d, d))
            _add(A, p, offset, (-1.0, 1.0), scaled(1.0 / length, d), constants[p, offset - 1] / length)
        if p + 3 < count:
            weights, along, height = _altitude(x, p)
            _add(A, p, 1, weights, along, constants[p, 3] / height)
    last = 3 * count - 3
    for i in range(3 * lattice.CLAMPED, last):  # Schur complement: what is left at the tip is its stiffness.
        reach = min(_BAND, 3 * count - i)
        for j in range(1, reach):
            factor = A[i, j] / A[i, 0]
            for k in range(j, reach):
                A[i + j, k - j] -= factor * A[i, k]
    for a in range(3):
        for b in range(3):
            out[a, b] = A[last + min(a, b), abs(a - b)]


@njit(cache=True)
def _altitude(x, p):
    """The shortest altitude of the tetrahedron from particle p on: weights, direction, length [m]."""
    a = row(x, p)
    b, c, d = minus(row(x, p + 1), a), minus(row(x, p + 2), a), minus(row(x, p + 3), a)
    n1, n2, n3 = cross(c, d), cross(d, b), cross(b, c)
    n0 = scaled(-1.0, plus(n1, plus(n2, n3)))
    best = n0
    most = dot(n0, n0)
    for n in (n1, n2, n3, plus(n1, n2), plus(n1, n3), plus(n2, n3)):
        if dot(n, n) > most:
            best = n
            most = dot(n, n)
    weights = dot(n0, best) / most, dot(n1, best) / most, dot(n2, best) / most, dot(n3, best) / most
    size = np.sqrt(most)
    return weights, scaled(1.0 / size, best), abs(dot(n1, b)) / size


@njit(cache=True)
def _add(A, p, step, weights, d, k):
    """Add k w_i w_j d d^T for particles p, p + step ... with weights w along a direction d, in place."""
    for i in range(len(weights)):
        for j in range(i, len(weights)):
            for a in range(3):
                for b in range(a if i == j else 0, 3):
                    A[3 * (p + step * i) + a, 3 * step * (j - i) + b - a] += k * weights[i] * weights[j] * d[a] * d[b]
