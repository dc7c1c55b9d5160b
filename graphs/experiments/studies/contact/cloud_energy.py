"""Energy of particles, and the work that is done against their links, which have none.

The tension K (r - l) of a link would be that of an energy if K were constant. (7) to (14) redistribute stiffness as
links fade, so that the work on a way depends on the way: it is added up on the ways that particles go, straight in
every step. Pressure (16) has the energy k_a m (ln(rho / rho_0) + rho_0 / rho - 1) where rho > rho_0.

Directions have none, as they follow the links; damping, air, collision and friction only take.
"""

import numpy as np

from hairpipe.particles.interaction import Law, find_pairs
from hairpipe.particles.links import measure_links, stiffen
from hairpipe.particles.model import Model
from hairpipe.particles.simulate import Prepared
from hairpipe.particles.step import Springs
from hairpipe.values.hair import ParticleState

PIECES = 32
"""Of a step, in each of which tensions are taken to go straight: more change less than a thousandth of the work."""


def energy_of(prepared: Prepared, state: ParticleState, gravity: float) -> float:
    """Return the energy of motion, of weight above y = 0 and of pressure of all particles [J]; gravity [m/s^2]."""
    model = prepared.model
    free = slice(prepared.model.deep, None)
    masses = model.masses[free]
    law = prepared.law
    squares = np.sum(state.velocities[free] ** 2, axis=1)
    moving = float(masses @ (0.5 * squares + gravity * state.points[free, 1]))
    if law is None:
        return moving
    return moving + pressure_energy(law, find_pairs(model.masses, state.points, law.h).density)


def pressure_energy(law: Law, density: np.ndarray) -> float:
    """Return what particles hold that are denser than at rest [J]; density at every one [kg/m^3], (N,)."""
    dense = np.maximum(density / law.rest, 1.0)
    return law.pressure * law.mass * float(np.sum(np.log(dense) + 1.0 / dense - 1.0))


def work_on_links(model: Model, springs: Springs, before: np.ndarray, after: np.ndarray) -> float:
    """Return the work [J] done against links while particles go straight from before to after [m], (N, 3) each."""
    total = 0.0
    lengths, tensions = _pull(model, springs, before)
    for piece in range(PIECES):
        were, pulled = lengths, tensions
        lengths, tensions = _pull(model, springs, before + (piece + 1) / PIECES * (after - before))
        total += 0.5 * float((pulled + tensions) @ (lengths - were))
    return total


def _pull(model: Model, springs: Springs, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return lengths [m] and tensions [N] of links, (E,) each, with particles at points."""
    links = model.links
    ways = np.empty((len(links.ends), 4))
    stiffness = np.empty(len(links.ends))
    measure_links(links, points, ways)
    stiffen(links, model.reach, springs.axial, ways, stiffness)
    return ways[:, 3], stiffness * (ways[:, 3] - springs.rest)
