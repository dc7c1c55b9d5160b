"""The particle model of a shot: flat arrays for kernels, computed once from the particles at rest.

The distance of a particle from its root is at most the length of the hair, with the stretch of its links: for hanging
hair `sag` at the root, half of that on average, and ten times as much at ten times its weight.

The smoothing kernel, equation (2) of Bando, Chen, Nishita 2003: Monaghan's cubic spline.

    W(r, h) = 1 / (4 pi h^3) (4 - 6 q^2 + 3 q^3)   q = r / h <= 1
                             (2 - q)^3             1 <= q <= 2
                             0                     beyond

Its integral over space is 1, and W(0, h) = 1 / (pi h^3).
"""

from typing import NamedTuple
from warnings import warn

import numpy as np
from numba import njit

from hairpipe.geometry.compile import inlined
from hairpipe.solve.boundary import motion_of_roots
from hairpipe.values import Particles
from hairpipe.values.groom import Driver, strand_lengths
from hairpipe.values.strand_arrays import name_strands


@inlined
def shape(q):
    """Return 4 pi h^3 W(q h, h)."""
    far, near = max(2.0 - q, 0.0), max(1.0 - q, 0.0)
    return far * far * far - 4.0 * near * near * near


@inlined
def slope(q):
    """Return the derivative of `shape` by q."""
    far, near = max(2.0 - q, 0.0), max(1.0 - q, 0.0)
    return 12.0 * near * near - 3.0 * far * far


def kernel(r: np.ndarray, h: float) -> np.ndarray:
    """Return W [1/m^3] at distances [m], (n,); pure."""
    far, near = np.maximum(2.0 - r / h, 0.0), np.maximum(1.0 - r / h, 0.0)
    return (far**3 - 4.0 * near**3) / (4.0 * np.pi * h**3)


LOAD = 10.0
"""Times the weight of hair under which links may stretch it."""
TORN = 100.0
"""Distance from the root, over the largest that is possible, at which a shot has diverged."""
ALIGNED = 8
"""Power of the alignment by which the link is chosen that never fades: one along the hair, not one across a parting."""


class Links(NamedTuple):
    """Springs between particles.

    ends      the particle towards the root first, (E, 2) int32
    lengths   at rest, l_ij [m], (E,)
    strength  c_ij l_ij / (4 pi h_1^3) of (5), (10), (11), so that times `shape` it is l k of (7) [1/m], (E,)
    keeps     distance beyond which a link fades no further [m], (E,); inf except for the link that holds a particle
    cosines   cosines between the hair at both ends and the vector from the first to the second, (E, 2)
    rows      range of particle k in others and by is rows[k]:rows[k+1], (N+1,) int32
    mids      start of the particles after it in that range, (N,) int32
    others    particles linked to each, and the links, (2 E,) int32 each
    by        see others
    """

    ends: np.ndarray
    lengths: np.ndarray
    strength: np.ndarray
    keeps: np.ndarray
    cosines: np.ndarray
    rows: np.ndarray
    mids: np.ndarray
    others: np.ndarray
    by: np.ndarray


class Model(NamedTuple):
    """Particles and their links.

    deep      number of particles below the skin, which move with their roots, and come first
    masses    [kg], (N,)
    sections  share of the cross-section of the hair of each particle in the total, A_i of (9), (N,)
    links     between them
    reach     h_1 [m]
    range     h_2 [m]
    hang      m g L / (l sag) with sag and g of 1: stiffness E A [N s^2/m] for the stretch at the root of hair of mean
              length L by its own weight
    """

    deep: int
    masses: np.ndarray
    sections: np.ndarray
    links: Links
    reach: float
    range: float
    hang: float


class Moving(NamedTuple):
    """Particles that move, and the tensions of their links; kernels write to them.

    points, velocities  [m], [m/s], (N, 3)
    tensions            [N], (E,)
    """

    points: np.ndarray
    velocities: np.ndarray
    tensions: np.ndarray


def build_model(particles: Particles) -> Model:
    """Build the arrays of particles; pure.

    Hanging hair is a bar. A particle has the volume V. With sum l K = E A towards the root, a strain e along the hair
    strains a link at an angle of cosine a by e a^2, with the energy sum K (l e a^2)^2 / 2 = e^2 E A s / 2, with s the
    mean of l a^4 weighted by l K: the modulus is E A s / V. The weight, m g / V per volume, stretches the hair at the
    root by m g L / (E A s).
    """
    deep = int(np.count_nonzero(particles.arcs < 0.0))
    ends, points = particles.links, particles.points
    ways = points[ends[:, 1]] - points[ends[:, 0]]
    lengths = np.linalg.norm(ways, axis=1)
    ways = ways / lengths[:, None]
    cosines = np.stack([np.sum(particles.directions[ends[:, end]] * ways, axis=1) for end in range(2)], axis=1)
    weights = particles.alignments * lengths**2 * kernel(lengths, particles.reach)
    keeps = np.full(len(ends), np.inf)  # Of each particle's links to the root the strongest one stops fading.
    order = np.lexsort((-weights * particles.alignments**ALIGNED, ends[:, 1]))
    strongest = order[np.unique(ends[order, 1], return_index=True)[1]]
    keeps[strongest] = lengths[strongest]
    own = ends.T.ravel()
    others = ends[:, ::-1].T.ravel()
    order = np.lexsort((others, own))
    rows = np.concatenate([[0], np.cumsum(np.bincount(own, minlength=len(points)))]).astype(np.int32)
    links = Links(
        ends,
        lengths,
        particles.alignments * lengths**2 / (4.0 * np.pi * particles.reach**3),
        keeps,
        cosines,
        rows,
        rows[:-1] + np.bincount(own[others < own], minlength=len(points)).astype(np.int32),
        others[order],
        np.tile(np.arange(len(ends), dtype=np.int32), 2)[order],
    )
    free = particles.masses[deep:]
    sections = (particles.masses / free.mean()) ** (2.0 / 3.0)
    mean = strand_lengths(particles.hair.points, particles.hair.offsets)[particles.strands[deep:]].mean()
    hang = free.mean() * mean * weights.sum() / (weights * lengths * particles.alignments**4).sum()
    return Model(deep, particles.masses, sections, links, particles.reach, particles.range, float(hang))


@njit(cache=True)
def inverse_masses(model: Model) -> np.ndarray:
    """Return 1 / m of particles, 0 of those below the skin [1/kg], (N,); pure."""
    inverses = np.zeros(len(model.masses))
    for k in range(model.deep, len(inverses)):
        inverses[k] = 1.0 / model.masses[k]
    return inverses


def reaches_of(particles: Particles, sag: float) -> np.ndarray:
    """Return the maximum distance of each particle from its root [m], (N,); pure.

    It is the arc length along the hair (for a curl, with positions along its axis, the share of its total length) plus
    the reach of links: a particle may represent hair at this distance.
    """
    lengths = strand_lengths(particles.hair.points, particles.hair.offsets)
    farthest = np.zeros(len(lengths))
    np.maximum.at(farthest, particles.strands, particles.arcs)
    share = np.maximum(particles.arcs, 0.0) / np.maximum(farthest, np.finfo(float).tiny)[particles.strands]
    return (share * lengths[particles.strands] + particles.reach) * (1.0 + LOAD * sag / 2.0)


def keep_within_reach(
    particles: Particles, reaches: np.ndarray, driver: Driver, deep: int, frame: int, moving: Moving
) -> None:
    """Move particles back to within reach of their roots along straight lines, in place, with a warning.

    They lose their speed away from the root.

    reaches  as `reaches_of` finds them [m], (N,)
    driver   driver of the roots at the end of the frame
    deep     number of particles below the skin, which come first

    Raises ArithmeticError if one is `TORN` times as far away.
    """
    hair = particles.hair
    strands = particles.strands[deep:]
    most = reaches[deep:]
    ends = hair.points[hair.offsets[:-1]]
    roots, drifts = (np.einsum("sij,sj->si", m[:, :, :3], ends) + m[:, :, 3] for m in motion_of_roots(driver, hair))
    ways = moving.points[deep:] - roots[strands]
    distances = np.linalg.norm(ways, axis=1)
    beyond = distances > most
    if not beyond.any():
        return
    worst = int(np.argmax(distances / most))
    names = name_strands(hair.ids[np.unique(strands[beyond])])
    message = (
        f"{np.count_nonzero(beyond)} of {len(beyond)} particles are too far from their roots at frame {frame}, the "
        f"farthest {distances[worst]:.3g} m, over {most[worst]:.3g} m, on strand {hair.ids[strands[worst]]}"
    )
    if distances[worst] > TORN * most[worst]:
        raise ArithmeticError(f"diverged: {message}: {names}")
    warn(f"{message}, and were moved back: {names} (more steps, or less wind)", stacklevel=3)
    units = ways[beyond] / distances[beyond, None]
    moving.points[deep:][beyond] = roots[strands[beyond]] + most[beyond, None] * units
    away = np.einsum("ni,ni->n", moving.velocities[deep:][beyond] - drifts[strands[beyond]], units)
    moving.velocities[deep:][beyond] -= np.maximum(away, 0.0)[:, None] * units
