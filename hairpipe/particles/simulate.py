"""A shot of particles: their start, their steps through a frame, and cuts, over which they go with their roots.

With `sag_free`, links support the hair as groomed: after one linear solve it neither sinks nor creeps. With K at rest,
and roots held, (sum K d d^T + eps) u = m g gives the sag of particles, and T = K d . u' the tension of
every link; its rest length becomes l - T / K. The diagonal eps, 1e-4 of the mean one, bounds the sag on links that
cannot support it. Hair on a body still sinks: its support is unknown here.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.errors import BadInput
from hairpipe.geometry.collider import Collider, SdfSample
from hairpipe.geometry.vec3 import dot, row
from hairpipe.laws.settings import BodyContact
from hairpipe.particles.contact import Planes, look, planes_of, push_out, stale
from hairpipe.particles.interaction import Law, PrintedLaw, exchange, find_pairs, push_pairs
from hairpipe.particles.links import measure_links, redirect, stiffen
from hairpipe.particles.model import Model, Moving, build_model, inverse_masses, keep_within_reach, reaches_of
from hairpipe.particles.settings import Interaction, ParticleContact, ParticleSettings, Printed
from hairpipe.particles.solve import build_system, set_blocks, solve
from hairpipe.particles.step import Forces, Springs, advance, advance_explicitly
from hairpipe.shot.breeze import LooseFibres, add_wind, warn_of_storm
from hairpipe.shot.build import bodies_of
from hairpipe.shot.shot import Frame, rigid_over_cut, warn_of_connections
from hairpipe.solve.boundary import motion_of_roots, velocities_around_roots
from hairpipe.values import Cloud, Groom, Particles
from hairpipe.values.groom import Driver
from hairpipe.values.hair import ParticleState
from hairpipe.values.strand_arrays import name_strands

DENSE = 0.99
"""Quantile of the density at rest up to which pressure leaves hair alone."""
LIMIT_OF_SOLVE = 1e18
"""Force [N], or damper [N s/m], whose square 32 bits do not hold: a solve would leave the particle where it is."""
NEAR_ROOT = 0.5
"""Largest distance of a particle from bodies, over its distance to the root along the hair."""
SOFT = 1e-4
"""Regularisation of the diagonal, over its mean."""
EXACT = 1e-4
"""Error of the solve, as `TOLERANCE` of a step."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """Constants of the particles of a shot.

    model     arrays of particles and links
    springs   parameters of links
    reaches   maximum distance of each particle from its root [m], (N,)
    law       laws of interaction; None: no interaction
    printed   laws used as printed in the paper; None: none
    """

    model: Model
    springs: Springs
    reaches: np.ndarray
    law: Law | None
    printed: PrintedLaw | None


def prepare(particles: Particles, settings: ParticleSettings) -> Prepared:
    """Find what links and pairs are like in a shot; pure."""
    model = build_model(particles)
    axial = settings.gravity * model.hang / settings.sag * model.sections
    rest = model.links.lengths
    if settings.sag_free is not None:
        rest = rest_lengths(model, particles.points, axial, settings.gravity, settings.sag_free.strain)
    if "links" in settings.printed:
        model = model._replace(links=model.links._replace(keeps=np.full(len(rest), np.inf)))
    law = printed = None
    if settings.interaction is not None:
        law, printed = laws_of(settings.interaction, settings.printed, model, particles.points)
    return Prepared(model, Springs(axial, rest, settings.damping), reaches_of(particles, settings.sag), law, printed)


def rest_lengths(model: Model, points: np.ndarray, axial: np.ndarray, gravity: float, strain: float) -> np.ndarray:
    """Return the rest lengths of links [m], (E,), for equilibrium of particles at points [m], (N, 3); pure.

    axial    E A of every particle [N], (N,)
    gravity  [m/s^2]
    strain   maximum relative change of a length
    """
    links = model.links
    deep = model.deep
    count = len(points)
    ways = np.empty((len(links.ends), 4))
    stiffness = np.empty(len(links.ends))
    measure_links(links, points, ways)
    stiffen(links, model.reach, axial, ways, stiffness)
    d = ways[:, :3]
    blocks = np.zeros((count, 6))
    outer = stiffness[:, None] * d[:, [0, 0, 0, 1, 1, 2]] * d[:, [0, 1, 2, 1, 2, 2]]
    for end in range(2):
        np.add.at(blocks, links.ends[:, end], outer)
    blocks[:, [0, 3, 5]] += SOFT * blocks[deep:, [0, 3, 5]].mean()
    joins = np.sqrt(stiffness)[:, None] * d
    system = build_system(links, deep)
    system.joins[:] = np.pad(joins[links.by], ((0, 0), (0, 1))).ravel()
    set_blocks(system, blocks)
    sunk, weights = np.zeros((count, 4), np.float32), np.zeros((count, 4), np.float32)
    weights[deep:, 1] = -gravity * model.masses[deep:]
    solve(system, weights.ravel(), sunk.ravel(), EXACT, 0.0)
    u = sunk[:, :3].astype(float)
    stretch = np.sum(d * (u[links.ends[:, 1]] - u[links.ends[:, 0]]), axis=1) / links.lengths
    return links.lengths * (1.0 - np.clip(stretch, -strain, strain))


def laws_of(
    interaction: Interaction, printed: Sequence[Printed], model: Model, points: np.ndarray
) -> tuple[Law, PrintedLaw | None]:
    """Return the laws by which particles act on each other that are at points [m], (N, 3), at rest; pure."""
    own = find_pairs(model.masses, points, model.range).density
    mass = float(model.masses.mean())
    rest = np.maximum(own, np.quantile(own[model.deep :], DENSE))
    ours = replace(interaction, **dict.fromkeys(set(printed) & {"pressure", "friction"}, 0.0))
    law = Law(ours.pressure, ours.collision, ours.friction, ours.bound, model.range, mass, rest)
    if ours == interaction:
        return law, None
    pressure, friction = interaction.pressure - ours.pressure, interaction.friction - ours.friction
    return law, PrintedLaw(pressure, friction, float(own[model.deep :].mean()), model.range, mass)


@dataclass(frozen=True, eq=False)
class ParticleSimulation:
    """Particles of a shot with their settings; a `hairpipe.shot.shot.Simulation`."""

    particles: Particles
    prepared: Prepared
    settings: ParticleSettings

    @property
    def groom(self) -> Groom:
        """The strands whose roots are led."""
        return self.particles.hair

    def start(self, frame: Frame) -> ParticleState:
        """Return particles where their roots are; BadInput where all of them are inside a body."""
        warn_of_connections(self.groom, frame, contact=self.settings.contact != ParticleContact())
        warn_of_storm(self.settings.wind)
        return start(self, frame, self._bodies_at(frame))

    def advance(self, state: ParticleState, frame: Frame) -> ParticleState:
        """Return particles at a frame.

        Raises ArithmeticError naming hair that is not finite, is torn from its roots, or is pushed beyond what a solve
        can handle.
        """
        return advance_frame(self, state, frame, self._bodies_at(frame))

    def move_over_cut(self, state: ParticleState, drivers: tuple[Driver, Driver]) -> ParticleState:
        """Return particles moved with their roots from the body before a cut to that after it.

        As `hairpipe.shot.shot.move_over_cut` for strands; directions rotate, tensions are unchanged, and no time
        passes.
        """
        strands = self.particles.strands
        rigid, turn = (motions[strands] for motions in rigid_over_cut(drivers, self.groom))
        before, after = (velocities_around_roots(driver, self.groom)[strands] for driver in drivers)
        points = _moved(rigid, state.points)
        velocities = _turned(turn, state.velocities - _moved(before, state.points)) + _moved(after, points)
        return replace(state, points=points, velocities=velocities, directions=_turned(turn, state.directions))

    def _bodies_at(self, frame: Frame) -> list[Collider]:
        contact = BodyContact(self.settings.contact.friction, self.settings.contact.thickness)
        return bodies_of(frame.surfaces, frame.parts, contact, frame.frame_dt)


def start(simulation: ParticleSimulation, frame: Frame, bodies: Sequence[Collider]) -> ParticleState:
    """Place particles rigidly with their roots, with links at rest."""
    particles, prepared = simulation.particles, simulation.prepared
    motions, rates = (m[particles.strands] for m in motion_of_roots(frame.drivers[1], particles.hair))
    points = _moved(motions, particles.points)
    directions = _turned(motions, particles.directions)
    deep, links = prepared.model.deep, prepared.model.links
    if bodies and (look(bodies, points[deep:], frame.frame_dt).distance < 0.0).all():
        right = "hair outside the body: check unit, position and pose of groom and body"
        raise BadInput("all particles are inside the body", where="in.body", right=right)
    stiffness = np.empty(len(links.ends))
    redirect(links, prepared.model.reach, prepared.springs.axial, deep, points, stiffness, directions.copy())
    tensions = stiffness * (links.lengths - prepared.springs.rest)
    return ParticleState(points, _moved(rates, particles.points), directions, tensions)


def advance_frame(
    simulation: ParticleSimulation, state: ParticleState, frame: Frame, bodies: Sequence[Collider]
) -> ParticleState:
    """Advance particles from the previous frame to this one; pure. ArithmeticError as `next_state`.

    With a printed formula, particles are not moved back to their roots, so that its failure is visible.
    """
    particles, prepared, settings = simulation.particles, simulation.prepared, simulation.settings
    model, springs = prepared.model, prepared.springs
    deep = model.deep
    acting = find_acting(simulation, state, frame, bodies)
    moving = Moving(state.points.copy(), state.velocities.copy(), state.tensions.copy())
    directions = state.directions.copy()
    stiffness = np.empty(len(model.links.ends))
    dt = frame.frame_dt / settings.steps
    given = model, springs, acting.forces, acting.planes, acting.roots, dt, moving

    def begin() -> None:
        redirect(model.links, model.reach, springs.axial, deep, moving.points, stiffness, directions)
        _act(prepared, moving.points, directions, dt, moving.velocities)

    if "steps" in settings.printed:
        advance_explicitly(*given, begin)
    else:
        advance(*given)
    _check_finite(particles, moving.points, moving.velocities)
    if not settings.printed:
        keep_within_reach(particles, prepared.reaches, frame.drivers[1], deep, frame.number, moving)
    if bodies:
        again = stale(acting.planes, acting.found, acting.places, moving.points, deep)
        there = look(bodies, moving.points[again], frame.frame_dt, reach=acting.planes.thickness[again])
        push_out(there, again, acting.planes, state.points, frame.frame_dt, moving)
    moving.velocities[:deep], directions[:deep] = acting.velocities, acting.directions
    redirect(model.links, model.reach, springs.axial, deep, moving.points, stiffness, directions)
    return ParticleState(moving.points, moving.velocities, directions, moving.tensions)


def _check_finite(particles: Particles, points: np.ndarray, velocities: np.ndarray) -> None:
    lost = ~(np.isfinite(points).all(1) & np.isfinite(velocities).all(1))
    if lost.any():
        named = name_strands(np.unique(particles.hair.ids[particles.strands[lost]]))
        raise ArithmeticError(f"{np.count_nonzero(lost)} particles are not finite, among them on {named}")


def _act(prepared: Prepared, points: np.ndarray, directions: np.ndarray, dt: float, velocities: np.ndarray) -> None:
    """Change velocities by what hair exchanges with hair in dt [s], in place."""
    if prepared.law is None:
        return
    inverses = inverse_masses(prepared.model)
    pairs = find_pairs(prepared.model.masses, points, prepared.model.range)
    exchange(prepared.law, pairs, inverses, points, directions, dt, velocities)
    if prepared.printed is not None:
        push_pairs(prepared.printed, pairs, inverses, points, directions, dt, velocities)


class Acting(NamedTuple):
    """Prescribed motion, forces and contacts of particles in a frame.

    roots       particles below the skin at the start of each step, and at the end [m], (steps + 1, deep, 3)
    velocities  of these at the end [m/s], (deep, 3), and their directions there, (deep, 3)
    forces      forces of gravity, air and hair
    places      predicted positions of particles at the end [m], (N, 3)
    found       probe of bodies there, and contact planes of these
    """

    roots: np.ndarray
    velocities: np.ndarray
    directions: np.ndarray
    forces: Forces
    places: np.ndarray
    found: SdfSample
    planes: Planes


def find_acting(
    simulation: ParticleSimulation, state: ParticleState, frame: Frame, bodies: Sequence[Collider]
) -> Acting:
    """Find what acts on particles from the previous frame to this one; pure."""
    particles, prepared, settings = simulation.particles, simulation.prepared, simulation.settings
    model, frame_dt = prepared.model, frame.frame_dt
    deep = model.deep
    rest, now = (particles.points[:deep], particles.directions[:deep]), (state.points[:deep], state.velocities[:deep])
    motions = motion_of_roots(frame.drivers[1], particles.hair)
    roots = _follow_roots(motions, particles.strands[:deep], rest, now, frame_dt, settings.steps)
    forces = _forces_on(prepared, settings, state, frame.began)
    ahead = state.velocities
    if "steps" not in settings.printed:
        ahead = ahead.copy()
        _act(prepared, state.points, state.directions, frame_dt, ahead)
        # As a force through the frame: what is given at its beginning would be undone in the steps that follow.
        forces.push[:] += model.masses[:, None] * (ahead - state.velocities) / frame_dt
    places = state.points + frame_dt * ahead
    _check_finite(particles, places, ahead)
    found = look(bodies, places, frame_dt, deep)
    thickness = np.minimum(settings.contact.thickness, NEAR_ROOT * np.maximum(particles.arcs, 0.0))
    return Acting(*roots, forces, places, found, planes_of(found, places, thickness, settings.contact.friction))


@njit(cache=True)
def _follow_roots(motions, strands, rest, now, dt, steps):
    """Return the first three arrays of `Acting`, by the cubic through places and velocities at both frames.

    rest, now  positions and directions at rest, positions and velocities at the previous frame
    """
    count = len(strands)
    ways = np.empty((steps + 1, count, 3))
    v1 = np.empty((count, 3))
    t1 = np.empty((count, 3))
    for k in range(count):
        motion, rate = motions[0][strands[k]], motions[1][strands[k]]
        x, t = row(rest[0], k), row(rest[1], k)
        for c in range(3):
            x0 = now[0][k, c]
            v0 = now[1][k, c]
            x1 = dot(row(motion, c), x) + motion[c, 3]
            v1[k, c] = dot(row(rate, c), x) + rate[c, 3]
            t1[k, c] = dot(row(motion, c), t)
            for step in range(steps + 1):  # Hermite's between both frames: smooth at the frames, too.
                s = step / steps
                place = (1 + 2 * s) * (1 - s) ** 2 * x0 + s * (1 - s) ** 2 * dt * v0
                ways[step, k, c] = place + s**2 * (3 - 2 * s) * x1 + s**2 * (s - 1) * dt * v1[k, c]
    return ways, v1, t1


def _forces_on(prepared: Prepared, settings: ParticleSettings, state: ParticleState, seconds: float) -> Forces:
    """Return gravity, and the drag of the air."""
    masses, links = prepared.model.masses, prepared.model.links
    forces = Forces(np.zeros((len(masses), 3)), np.zeros((len(masses), 6)))
    forces.push[:, 1] = -settings.gravity * masses
    if settings.wind is None:
        forces.drag[:, [0, 3, 5]] = settings.air.drag * masses[:, None]
    else:
        segment = float(links.lengths.mean())
        counts = masses / (settings.fibre.line_density * segment)
        now = state.points, state.directions, state.velocities
        add_wind(settings.wind, LooseFibres(*now, counts, segment, settings.fibre.diameter), seconds, *forces)
    strongest = max(float(np.abs(values).max()) for values in forces)
    if not strongest < LIMIT_OF_SOLVE:
        message = f"diverged: the force of air on a particle is {strongest:.3g} N, or N s/m"
        raise ArithmeticError(f"{message}, above the limit of the solver, {LIMIT_OF_SOLVE:.3g} (less wind)")
    return forces


def _moved(motions: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return points x -> R x + t [m], (n, 3), by rigid motions [R | t], (n, 3, 4)."""
    return _turned(motions, points) + motions[:, :, 3]


def _turned(motions: np.ndarray, directions: np.ndarray) -> np.ndarray:
    return np.einsum("nij,nj->ni", motions[:, :, :3], directions)


def cloud_of(state: ParticleState) -> Cloud:
    """Return what is shown of particles; pure."""
    return Cloud(state.points, state.velocities.astype(np.float32), state.directions)
