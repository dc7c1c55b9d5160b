"""A frame of hair in locks: guides are simulated, followers interpolated; then guides are reassigned."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hairpipe.data import BodyParts, LevelSet, Strands
from hairpipe.data.hair import HairState, LockState
from hairpipe.errors import BadInput
from hairpipe.groom.keys.key_turns import turns_since
from hairpipe.groom.keys.push_out import pushed_out
from hairpipe.groom.strand_arrays import points_of_strands
from hairpipe.kernels.simd_arrays import copied
from hairpipe.sim.axis import axis_of, scatter
from hairpipe.sim.boundary import Lead, held_tips, motion_of_roots
from hairpipe.sim.contact.hair.stiction import Connections
from hairpipe.sim.hair_model import HairModel
from hairpipe.sim.interactions import own_interactions
from hairpipe.sim.locks.carrying import GuideMotion, carried
from hairpipe.sim.locks.grouping import Deviations, Grouping, follows, grouped, is_carried
from hairpipe.sim.locks.guides import Guides, take_guides
from hairpipe.sim.locks.joining import ages_of
from hairpipe.sim.locks.places import FOLLOWED, Places, guides_beside, no_places, renewed
from hairpipe.sim.locks.standing import stand_up
from hairpipe.sim.settings import Scene


class Around(NamedTuple):
    """Inputs of a frame of hair in locks.

    lead             lead of the roots
    surfaces, parts  level sets of bodies
    frame_dt         time since the previous frame [s]
    """

    lead: Lead
    surfaces: Sequence[LevelSet]
    parts: Sequence[BodyParts]
    frame_dt: float


def check_locks(hair: HairModel, lead: Lead, scene: Scene) -> None:
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
    if len(held_tips(lead, hair.groom, hair.layout)):
        raise BadInput("locks require free tips", where="locks", right="strands held at the root alone")


def no_locks(strands: int, stuck: int = 0) -> LockState:
    """Simulate every one of so many strands, of which so many connections have just been made."""
    leaders = np.arange(strands, dtype=np.int32)
    ages = np.zeros(stuck, np.int32)
    nobody = np.full(strands, -1, np.int32)
    errors = np.full(strands, np.nan, np.float32)
    apart = np.zeros(strands, np.float32)
    return LockState(leaders, ages, *no_places(0), apart, nobody, nobody, errors, turn=0, since=0)


def advance_locked(
    hair: HairModel,
    previous: HairState,
    around: Around,
    scene: Scene,
    advance: Callable[[Guides, HairState], HairState],
) -> HairState:
    """Return hair in locks at the next frame; pure.

    scene    scene accepted by `check_locks`
    advance  function that simulates guides from the previous frame to this one
    """
    locks = scene.locks
    stiction = scene.stiction
    offsets = hair.layout.offsets
    assert locks is not None and stiction is not None
    known = previous.locks or no_locks(len(hair.groom.ids), len(previous.stuck))
    guides = take_guides(hair, known.leaders)
    before = guides.state_of(previous)
    moved = advance(guides, before)
    ages = ages_of(before.stuck, before.stuck_at, known.ages, moved.stuck, moved.stuck_at)
    motion = motion_of(guides, moved, around.lead)
    state = guides.put(previous, moved)
    by_guides, deviations = _carry(hair, known, motion, around, scene.contact.thickness)
    simulated = np.repeat(~follows(known.leaders), np.diff(offsets))[:, None]
    points, velocities = (np.where(simulated, *both) for both in zip(motion[:2], by_guides, strict=True))
    stuck = Connections(state.stuck, state.stuck_at)
    now = grouped(known, stuck, ages, deviations, (points, offsets), locks, stiction.closest)
    stand = follows(known.leaders) & ~follows(now.leaders)
    turns = _with_turns(hair, motion, points, velocities, stand, around.lead)
    # An audit that goes on compares with where hair would be by now, not with where it is.
    places = _places(known, now, points if now.since == 0 else by_guides[0], offsets, turns)
    state = stand_up(hair, _on_axes(hair, state, points, velocities), points, velocities, stand, around.lead)
    left = np.where(follows(now.leaders), deviations.disagreement, 0.0).astype(np.float32)
    record = LockState(
        now.leaders, now.ages, *places, left, now.audited, now.parted, now.errors, turn=now.turn, since=now.since
    )
    return replace(state, stuck=now.connections.segments, stuck_at=now.connections.fractions, locks=record)


def motion_of(guides: Guides, moved: HairState, lead: Lead) -> GuideMotion:
    """Return how guides move at a frame, as points of the groom."""
    groom, layout = guides.hair.groom, guides.hair.layout
    points = layout.axis(moved.positions)
    velocities = layout.axis(moved.velocities).astype(np.float64)
    roots = (motions[guides.strands] for motions in motion_of_roots(lead, guides.whole.groom))
    turns = turns_since(groom.points, Strands(points, velocities, layout.offsets, guides.hair.diameter), *roots)
    out = []
    for values in (points, velocities, turns.turns, turns.spins):
        out.append(np.zeros((len(guides.numbers), *values.shape[1:])))
        out[-1][guides.points] = values
    return GuideMotion(*out)


def _carry(
    hair: HairModel, known: LockState, motion: GuideMotion, around: Around, thickness: float
) -> tuple[tuple[np.ndarray, np.ndarray], Deviations]:
    """Interpolate followers, audited strands and trials, and push them out of bodies to a distance [m]; pure.

    Returns points and velocities of all strands, (P, 3) each, and the deviations of the interpolated ones.
    """
    groom = hair.groom
    offsets = hair.layout.offsets
    points = motion.points
    velocities = motion.velocities
    disagreement, pushed = np.zeros((2, len(known.leaders)))
    beside = np.full((len(known.leaders), FOLLOWED), -1, np.int32)
    among = is_carried(known.leaders, known.audited)
    if among.any():
        strands = np.flatnonzero(among)
        places = Places(known.points, known.offsets, known.bends)
        roots = motion_of_roots(around.lead, groom)
        tried = known.parted[strands] >= 0
        on_trial = np.repeat(tried, np.diff(offsets)[strands])
        beside[strands[tried]] = guides_beside(strands[tried], places.points[on_trial], offsets)
        x, v, disagreement[strands] = carried(strands, places, motion, offsets, groom.points, roots)
        rows = points_of_strands(strands, offsets)
        points = points.copy()
        velocities = velocities.copy()
        points[rows], velocities[rows] = x, v
        shown = Strands(points, velocities, offsets, hair.diameter)
        outside = pushed_out(shown, among, around.surfaces, around.parts, thickness, around.frame_dt)
        pushed = _distances(outside.points, points, offsets)
        points, velocities = outside.points, outside.velocities
    off = _distances(motion.points, points, offsets)
    return (points, velocities), Deviations(disagreement, pushed, off, beside)


def _distances(points: np.ndarray, others: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the rms distance over the points of each strand [m], (S,)."""
    return np.sqrt(np.add.reduceat(((points - others) ** 2).sum(axis=1), offsets[:-1]) / np.diff(offsets))


def _places(known: LockState, now: Grouping, points: np.ndarray, offsets: np.ndarray, turns: np.ndarray) -> Places:
    """Return what hairs follow from now on that are at points [m], (P, 3); audited strands follow again."""
    before = is_carried(known.leaders, known.audited)
    ended = now.since == 0
    keeps = before & ~((known.audited >= 0) & ended)
    rows = np.repeat(keeps[before], np.diff(offsets)[before])
    followed = Places(*(values[rows] for values in (known.points, known.offsets, known.bends)))
    among = is_carried(now.leaders, now.audited)
    return renewed((np.flatnonzero(keeps), followed), among, points, offsets, turns)


def _with_turns(
    hair: HairModel, motion: GuideMotion, points: np.ndarray, velocities: np.ndarray, stand: np.ndarray, lead: Lead
) -> np.ndarray:
    """Return the turns of guides and of strands that are simulated from now on, (P, 3, 3)."""
    if not stand.any():
        return motion.turns
    shown = Strands(points, velocities, hair.layout.offsets, hair.diameter)
    every = turns_since(hair.groom.points, shown, *motion_of_roots(lead, hair.groom)).turns
    return np.where(np.repeat(stand, np.diff(hair.layout.offsets))[:, None, None], every, motion.turns)


def _on_axes(hair: HairModel, state: HairState, points: np.ndarray, velocities: np.ndarray) -> HairState:
    """Return the state with the axes of all strands where they are; pure."""
    axis = axis_of(hair.layout)
    x = copied(state.positions)
    v = copied(state.velocities)
    scatter(axis, points, x)
    scatter(axis, velocities.astype(v.dtype), v)
    return replace(state, positions=x, velocities=v)
