"""Spring constants that give the network the stiffness of an elastic rod, at any resolution.

EI and GJ of the network grow as k l^2, and with altitude springs they mix, so bending and torsion
constants are fitted: the linear response of a straight strand to an end couple must be M L / EI about both transverse
axes (their mean) and M L / GJ about its own.

The network of a curl, fitted to the compliance of a rod of the same shape.

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

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.vec3 import cross, dot, minus, plus, row, scaled
from hairpipe.laws.settings import Construction
from hairpipe.strands import lattice
from hairpipe.strands.lattice import altitude_vectors, area_vectors
from hairpipe.strands.material import Material, Section, taken

_PROBED = 20  # segments the response is measured over: the lattice repeats twice, so directions average out
_MARGIN = 3  # segments left at either end
_GRID = 0.02  # of the edges' compliance over that of bending
_SOFTEST = 0.1  # beyond, an edge gives way before the strand bends
_SINGULAR = np.deg2rad(20.0)  # a lattice that turns by less than this from the plane has no stiffness to fit
_ENOUGH = 1e-7  # misfit of the logarithm of a stiffness; rounding leaves 1e-8
_STIFFEST = 1e-4  # of that compliance: stiffer edges change nothing and cost digits


def spring_constants(material: Material | Section, construction: Construction, length: np.ndarray) -> np.ndarray:
    """Fit the four spring constants of strands to their material, and remove the springs that the construction omits.

    A lattice without turn has modes of zero stiffness: its constants are those of the default lattice.

    material  of strands, or at the places of their springs, (s, n): one Poisson ratio for all
    length    length of a segment [m], (s,) or (s, 1)
    returns   edge, bending, torsion and altitude constants: force per unit strain [N], (4, s) or (4, s, n)

    The softening of short edges is limited, see `softenings`.
    """
    unit = material.bending / length**2
    axial = edge_constants(material, length)
    slack = unit / axial
    ratio = float(np.ravel(material.torsion)[0] / np.ravel(material.bending)[0])
    # Fits lie on a fixed grid, not at the lengths at hand: a strand's constants must not depend on the other strands.
    below = np.floor(slack / _GRID).astype(int)
    levels, places = np.unique(below, return_inverse=True)
    turn = np.deg2rad(construction.turn)
    turn = turn if works(turn) else lattice.TURN
    fits = [[_fit(n * _GRID, ratio, construction.altitude, turn) for n in (levels + up).tolist()] for up in (0, 1)]
    low, high = np.array(fits)[:, places.reshape(below.shape)]
    bending, torsion = unit / np.moveaxis(low + (slack / _GRID - below)[..., None] * (high - low), -1, 0)
    bending, torsion = construction.bending * bending, construction.torsion * torsion
    return np.stack([axial, bending, torsion, construction.altitude * torsion])


def edge_constants(material: Material | Section, length: np.ndarray) -> np.ndarray:
    """Return the constants of edges [N], as `spring_constants`, softened as far as segments [m] allow."""
    return material.axial * material.softening / softenings(material, length)


def softenings(material: Material | Section, length: np.ndarray) -> np.ndarray:
    """Return the divisors of the axial stiffness of strands: less where edges would be softer than bending.

    material, length  as in `spring_constants`; returns as many as these broadcast to

    A divisor below 1 is not physical: segments shorter than 0.8 of the diameter are not a rod.
    """
    slack = material.bending / (material.axial * length**2)
    return material.softening * np.minimum(1.0, _SOFTEST / slack)


def works(turn: float) -> bool:
    """Whether a lattice that turns so [rad] has stiffness in all of its modes."""
    return bool(_SINGULAR < turn < np.pi - _SINGULAR)


@lru_cache(maxsize=64)
def _fit(slack: float, ratio: float, altitude: float, turn: float) -> tuple[float, float]:
    """Compliances of bending and torsion springs for EI = 1, GJ = ratio and segments of length 1."""
    log = np.log([1 / 6.2, 1 / 3.7])
    rod = straight_rod(turn)
    for _ in range(30):
        misfit = _misfit(log, slack, ratio, altitude, rod)
        if np.abs(misfit).max() < _ENOUGH:
            break
        slopes = [(_misfit(log + step, slack, ratio, altitude, rod) - misfit) / 1e-6 for step in np.eye(2) * 1e-6]
        log = log - np.clip(np.linalg.solve(np.transpose(slopes), misfit), -1, 1)
    else:
        raise BadInput(
            f"no spring constants give the stiffness of a rod at a turn of {np.rad2deg(turn):.3g} deg",
            where="construction",
            right="turn = 60 to 110, or altitude = 0",
        )
    bending, torsion = np.exp(log)
    return float(bending), float(torsion)


def _misfit(log: np.ndarray, slack: float, ratio: float, altitude: float, rod: "Springs") -> np.ndarray:
    bending, torsion = np.exp(-log)
    edge = 1 / max(slack, _STIFFEST)
    stiffness = rod_stiffness(np.array([edge, bending, torsion, altitude * torsion]), rod)
    return np.log(stiffness / [1.0, ratio])


class Springs(NamedTuple):
    """The springs of a network at rest, in the order in which their second derivatives are added.

    particles  at rest [m], (p, 3)
    kinds      kinds of the springs: 0 edge, 1 bending, 2 torsion, 3 altitude, (n,)
    lengths    at rest [m], (n,)
    owners     springs of the products, (m,)
    places     indices of the products in the flat matrix of second derivatives, (m,)
    products   w_i w_j n n^T for every pair of particles of a spring with weights w along its direction n, (m,)
    """

    particles: np.ndarray
    kinds: np.ndarray
    lengths: np.ndarray
    owners: np.ndarray
    places: np.ndarray
    products: np.ndarray


def straight_rod(turn: float) -> Springs:
    """Make the straight network with segments of length 1 whose response is measured; turn of its lattice [rad]."""
    segments = _PROBED + 2 * _MARGIN
    axis = np.zeros((1, segments + 1, 3))
    axis[0, :, 2] = np.arange(segments + 1)
    return springs_of(lattice.perturb(axis, np.array([[0.0, 1.0, 0.0]]), turn)[0])


def rod_stiffness(constants: np.ndarray, rod: Springs) -> np.ndarray:
    """Bending and torsional stiffness of a straight network, see `straight_rod`."""
    particles = rod.particles
    free = slice(3 * lattice.CLAMPED, None)
    hessian = hessian_of(rod, constants)[free, free]
    loads = np.zeros((len(particles), 3, 3))
    loads[-3:] = _couples(particles[-3:])
    moved = np.zeros((len(particles) * 3, 3))
    moved[free] = np.linalg.solve(hessian, loads.reshape(-1, 3)[free])
    moved = moved.reshape(-1, 3, 3)
    start = 2 * _MARGIN
    first, last = (np.diag(_rotation(particles, moved, p)) for p in (start, start + 2 * _PROBED))
    per_length = (last - first) / _PROBED
    return 1 / np.array([per_length[:2].mean(), per_length[2]])


def _couples(triangle: np.ndarray) -> np.ndarray:
    """Forces on three points that make a unit couple about x, y and z: (3, 3 components, 3 couples)."""
    arms = triangle - triangle.mean(0)
    spin = np.linalg.inv(_inertia(arms))
    return np.cross(spin.T[None], arms[:, None]).transpose(0, 2, 1)


def _rotation(particles: np.ndarray, moved: np.ndarray, first: int) -> np.ndarray:
    """Best rotation vectors of three particles in a row under the three displacements: (3 components, 3 couples)."""
    arms = particles[first : first + 3] - particles[first : first + 3].mean(0)
    torque = np.cross(arms[:, None], moved[first : first + 3].transpose(0, 2, 1)).sum(0)
    return np.linalg.solve(_inertia(arms), torque.T)


def _inertia(arms: np.ndarray) -> np.ndarray:
    return np.eye(3) * np.sum(arms**2) - arms.T @ arms


def springs_of(particles: np.ndarray) -> Springs:
    """List the springs of a network at rest; of every tetrahedron, the shortest altitude. Particles [m], (p, 3)."""
    count = len(particles)
    kinds, lengths, places, products = [], [], [], []

    def add(kind: int, length: float, indices: np.ndarray, weights: np.ndarray, direction: np.ndarray) -> None:
        gradient = (weights[:, None] * direction).reshape(-1)
        rows = (3 * indices[:, None] + np.arange(3)).reshape(-1)
        kinds.append(kind)
        lengths.append(length)
        places.append((3 * count * rows[:, None] + rows).reshape(-1))
        products.append(np.outer(gradient, gradient).reshape(-1))

    for i in range(count):
        for offset, kind in ((1, 0), (2, i % 2), (3, 2)):
            if i + offset < count:
                span = particles[i + offset] - particles[i]
                length = float(np.linalg.norm(span))
                add(kind, length, np.array([i, i + offset]), np.array([-1.0, 1.0]), span / length)
    area, volume = (values[0] for values in area_vectors(lattice.tetrahedra(particles[None])))
    for i in range(count - 3):
        candidates = altitude_vectors(area[i])
        size = np.linalg.norm(candidates, axis=1)
        best = np.argmax(size)
        weights = area[i] @ candidates[best] / size[best] ** 2
        add(3, abs(volume[i]) / size[best], np.arange(i, i + 4), weights, candidates[best] / size[best])
    owners = np.repeat(np.arange(len(kinds)), [len(own) for own in places])
    return Springs(
        particles, np.array(kinds), np.array(lengths), owners, np.concatenate(places), np.concatenate(products)
    )


def hessian_of(springs: Springs, constants: np.ndarray) -> np.ndarray:
    """Second derivatives of the network's energy at rest [N/m], (3p, 3p); constants as for `rod_stiffness`."""
    size = springs.particles.size
    hessian = np.zeros(size * size)
    given = constants[springs.kinds]
    # An altitude may have no length where there is to be no altitude spring.
    stiffness = np.divide(given, springs.lengths, out=np.zeros_like(given), where=given != 0)
    np.add.at(hessian, springs.places, stiffness[springs.owners] * springs.products)
    return hessian.reshape(size, size)


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
    """Return L of the compliance of the tip of rods, C^ = L L^T [m/N], (s, 3, 3)."""
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
    """Return the stiffness of the tip of networks at rest, with all but the clamp free [N/m], (s, 3, 3)."""
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
