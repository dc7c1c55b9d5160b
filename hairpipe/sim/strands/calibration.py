"""Spring constants that give the network the stiffness of an elastic rod, at any resolution.

EI and GJ of the network grow as k l^2, and with altitude springs they mix, so bending and torsion
constants are fitted: the linear response of a straight strand to an end couple must be M L / EI about both transverse
axes (their mean) and M L / GJ about its own.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.sim.material import Material
from hairpipe.sim.strands import lattice
from hairpipe.sim.strands.construction import Construction
from hairpipe.sim.strands.fibres import Section
from hairpipe.sim.strands.tetrahedra import altitude_vectors, area_vectors

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
    """Compliances of bending and torsion springs for EI = 1, GJ = ratio and segments of length 1.

    slack     compliance of the edges; compliances in series add, so the fit is nearly linear in it
    altitude  ratio of the altitude constant to the torsion constant
    turn      turn of the lattice [rad]
    """
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
    """Bending and torsional stiffness of a straight network, see `straight_rod`.

    constants  edge, bending, torsion, altitude [N], (4,)
    returns    EI (mean of both transverse axes) and GJ [N m^2], (2,)
    """
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
