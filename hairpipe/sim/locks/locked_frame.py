"""A frame of hair in locks: guides are simulated, followers interpolated; then strands get new roles.

Other code uses locks by this module, and by the questions that `LockState` answers.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hairpipe.data.hair import HairState
from hairpipe.data.locks import LockState, no_locks
from hairpipe.errors import BadInput
from hairpipe.kernels.simd_arrays import copied
from hairpipe.sim.axis import axis_of
from hairpipe.sim.boundary import Driver, held_tips, motion_of_roots
from hairpipe.sim.contact.hair.stiction import Connections, ages_of
from hairpipe.sim.hair_model import HairModel
from hairpipe.sim.interactions import own_interactions
from hairpipe.sim.locks.auditing import about_roots
from hairpipe.sim.locks.following import follow
from hairpipe.sim.locks.guides import take_guides
from hairpipe.sim.locks.places import renewed
from hairpipe.sim.locks.regrouping import regrouped
from hairpipe.sim.locks.standing import motion_along, stand_up
from hairpipe.sim.settings import Scene
from hairpipe.sim.shot import Frame

Simulate = Callable[[HairModel, HairState, tuple[Driver, Driver]], HairState]
"""Simulates strands from their state at the previous frame to this one, from the drivers of their roots at both."""


def check_locks(hair: HairModel, driver: Driver, scene: Scene) -> None:
    """Raise BadInput where hair cannot be in locks: it must stick, pair by pair, in the solve, and have free tips."""
    if scene.stiction is None:
        raise BadInput("locks require stiction", where="locks", right="[hair.stiction], too")
    if scene.volume is not None or (scene.collisions is not None and scene.collisions.solver == "sweep"):
        right = 'solver = "coupled", and no [hair.volume]'
        raise BadInput("locks require the coupled contact solver", where="locks", right=right)
    if own_interactions(scene):
        raise BadInput(
            "user-defined interactions would act on guides only",
            where="locks",
            right="locks or user-defined interactions",
        )
    if len(held_tips(driver, hair.groom, hair.layout)):
        raise BadInput("locks require free tips", where="locks", right="strands held at the root alone")


def advance_locked(hair: HairModel, previous: HairState, frame: Frame, scene: Scene, simulate: Simulate) -> HairState:
    """Return hair in locks at a frame, in a scene accepted by `check_locks`; pure."""
    locks = scene.locks
    stiction = scene.stiction
    offsets = hair.layout.offsets
    driver = frame.drivers[1]
    assert locks is not None and stiction is not None
    known = previous.locks or _first_locks(hair, previous, frame.drivers[0])
    guides = take_guides(hair, known.leaders)
    before = guides.state_of(previous)
    moved = simulate(guides.hair, before, guides.drivers_of(frame.drivers))
    motion = guides.motion_of(moved, driver)
    found = follow(hair, known, motion, frame, scene.contact.thickness)
    state = _on_axes(hair, guides.put(previous, moved), found.points, found.velocities)
    ages = ages_of(before.stuck, before.stuck_at, known.ages, moved.stuck, moved.stuck_at)
    roots = motion_of_roots(driver, hair.groom)[0]
    now, stuck = regrouped(
        known, Connections(state.stuck, state.stuck_at), ages, found, offsets, roots, locks, stiction.closest
    )
    freed = known.follows & ~now.follows
    if freed.any():
        motion = motion_along(hair, found.points, found.velocities, driver)
        state = stand_up(hair, state, motion, freed, driver)
    among = np.flatnonzero(known.interpolated)
    if now.since == 0:  # The audit has ended: what was compared follows from where it is.
        keeps, points = known.follows, found.points
    else:
        keeps, points = known.interpolated, found.interpolated
    places = renewed(known.places, among, keeps, now.interpolated, points, offsets, motion.turns)
    return replace(state, stuck=stuck.segments, stuck_at=stuck.fractions, locks=replace(now, places=places))


def _first_locks(hair: HairModel, state: HairState, driver: Driver) -> LockState:
    """Return the locks of hair that was in none before."""
    points = hair.layout.axis(state.positions)
    reference = about_roots(points, hair.layout.offsets, motion_of_roots(driver, hair.groom)[0])
    return no_locks(len(hair.groom.ids), len(state.stuck), reference)


def with_particles(hair: HairModel, state: HairState, driver: Driver) -> HairState:
    """Return the state with the particles of followers about their axes, which alone are up to date; pure."""
    if state.locks is None:
        return state
    points, velocities = hair.layout.axis(state.positions), hair.layout.axis(state.velocities)
    return stand_up(hair, state, motion_along(hair, points, velocities, driver), state.locks.follows, driver)


def _on_axes(hair: HairModel, state: HairState, points: np.ndarray, velocities: np.ndarray) -> HairState:
    """Return the state with the axes of all strands where they are; pure."""
    axis = axis_of(hair.layout)
    x = copied(state.positions)
    v = copied(state.velocities)
    axis.scatter(points, x)
    axis.scatter(velocities.astype(v.dtype), v)
    return replace(state, positions=x, velocities=v)
