"""A frame of hair in locks: guides are simulated, the others carried; then locks part, and others are joined."""

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
from hairpipe.sim.locks.guides import Guides, take_guides
from hairpipe.sim.locks.inheriting import inherited
from hairpipe.sim.locks.joining import ages_of, guides_of, joined
from hairpipe.sim.locks.places import Places, find_places, no_places
from hairpipe.sim.locks.standing import stand_up
from hairpipe.sim.settings import Scene


class Around(NamedTuple):
    """What hair in locks is given of a frame.

    lead             of the roots
    surfaces, parts  of bodies
    frame_dt         since the frame before [s]
    """

    lead: Lead
    surfaces: Sequence[LevelSet]
    parts: Sequence[BodyParts]
    frame_dt: float


def check_locks(hair: HairModel, lead: Lead, scene: Scene) -> None:
    """Raise BadInput where hair cannot be in locks: it must stick, pair by pair, in the solve, and have free tips."""
    if scene.stiction is None:
        raise BadInput("locks are of hair that sticks together", where="locks", right="[hair.stiction], too")
    if scene.volume is not None or (scene.collisions is not None and scene.collisions.solver == "sweep"):
        right = 'solver = "coupled", and no [hair.volume]'
        raise BadInput("locks keep distances pair by pair, in the solve", where="locks", right=right)
    if own_interactions(scene):
        raise BadInput("interactions of your own would see guides alone", where="locks", right="one or the other")
    if len(held_tips(lead, hair.groom, hair.layout)):
        raise BadInput(
            "hair that follows in a lock has a free tip", where="locks", right="strands held at the root alone"
        )


def no_locks(strands: int, stuck: int = 0) -> LockState:
    """Simulate every one of so many strands, of which so many connections have just been made."""
    none = no_places(0)
    leaders, ages = np.arange(strands, dtype=np.int32), np.zeros(stuck, np.int32)
    return LockState(leaders, ages, *none, disagreement=np.zeros(strands, np.float32))


def advance_locked(
    hair: HairModel,
    previous: HairState,
    around: Around,
    scene: Scene,
    advance: Callable[[HairModel, HairState], HairState],
) -> HairState:
    """Return hair in locks at the next frame; pure.

    scene    one that `check_locks` lets pass
    advance  simulates strands from the frame before to this one
    """
    locks, stiction = scene.locks, scene.stiction
    assert locks is not None and stiction is not None
    known = previous.locks or no_locks(len(hair.groom.ids), len(previous.stuck))
    guides = take_guides(hair, known.leaders)
    before = guides.state_of(previous)
    moved = advance(guides.hair, before)
    ages = ages_of(before.stuck, before.stuck_at, known.ages, moved.stuck, moved.stuck_at)
    motion = motion_of(guides, moved, around.lead)
    followers, places = _followers(known), _places(known)
    disagreement, strayed = np.zeros((2, len(known.leaders)))
    state, points, velocities = guides.put(previous, moved), motion.points, motion.velocities
    if len(followers):
        disagreement, strayed = _carry(hair, motion, followers, places, around, scene.contact.thickness)
    loose = np.maximum(disagreement, strayed) > locks.tolerance
    leaders = np.where(loose, np.arange(len(loose)), known.leaders).astype(np.int32)
    offsets, stuck = hair.layout.offsets, Connections(state.stuck, state.stuck_at)
    leaders = guides_of(joined(leaders, stuck.segments, ages, offsets, locks), leaders, points, offsets)
    stuck, ages = inherited(stuck, ages, leaders, offsets, stiction.closest)
    turns = _with_turns(hair, motion, loose, around.lead)
    places = _renewed(followers, places, leaders, points, offsets, turns)
    state = stand_up(hair, _on_axes(hair, state, points, velocities), points, velocities, loose, around.lead)
    left = np.where(leaders == np.arange(len(leaders)), 0.0, disagreement).astype(np.float32)
    now = LockState(leaders, ages, *places, disagreement=left)
    return replace(state, stuck=stuck.segments, stuck_at=stuck.fractions, locks=now)


def motion_of(guides: Guides, moved: HairState, lead: Lead) -> GuideMotion:
    """Return how guides move at a frame, as points of the groom."""
    groom, layout = guides.hair.groom, guides.hair.layout
    points, velocities = layout.axis(moved.positions), layout.axis(moved.velocities).astype(np.float64)
    roots = (motions[guides.strands] for motions in motion_of_roots(lead, guides.whole.groom))
    turns = turns_since(groom.points, Strands(points, velocities, layout.offsets, guides.hair.diameter), *roots)
    out = []
    for values in (points, velocities, turns.turns, turns.spins):
        out.append(np.zeros((len(guides.numbers), *values.shape[1:])))
        out[-1][guides.points] = values
    return GuideMotion(*out)


def _followers(known: LockState) -> np.ndarray:
    return np.flatnonzero(known.leaders != np.arange(len(known.leaders)))


def _places(known: LockState) -> Places:
    return Places(known.points, known.offsets, known.bends)


def _carry(
    hair: HairModel, motion: GuideMotion, followers: np.ndarray, places: Places, around: Around, thickness: float
) -> tuple[np.ndarray, np.ndarray]:
    """Carry followers, and push them out of bodies to a distance [m]; adds them to what guides do, in place.

    Returns what their guides disagree by and how far bodies have pushed them, rms [m], (S,) each.
    """
    groom, offsets = hair.groom, hair.layout.offsets
    roots = motion_of_roots(around.lead, groom)
    x, v, disagree = carried(followers, places, motion, offsets, groom.points, roots)
    rows = points_of_strands(followers, offsets)
    motion.points[rows], motion.velocities[rows] = x, v
    among = np.zeros(len(offsets) - 1, np.bool_)
    among[followers] = True
    shown = Strands(motion.points, motion.velocities, offsets, hair.diameter)
    shown = pushed_out(shown, among, around.surfaces, around.parts, thickness, around.frame_dt)
    squares = np.add.reduceat(((shown.points - motion.points) ** 2).sum(axis=1), offsets[:-1])
    motion.points[rows], motion.velocities[rows] = shown.points[rows], shown.velocities[rows]
    disagreement = np.zeros(len(among))
    disagreement[followers] = disagree
    return disagreement, np.sqrt(squares / np.diff(offsets))


def _with_turns(hair: HairModel, motion: GuideMotion, loose: np.ndarray, lead: Lead) -> np.ndarray:
    """Return the turns of guides and of strands that are simulated from now on, (P, 3, 3)."""
    if not loose.any():
        return motion.turns
    shown = Strands(motion.points, motion.velocities, hair.layout.offsets, hair.diameter)
    every = turns_since(hair.groom.points, shown, *motion_of_roots(lead, hair.groom)).turns
    return np.where(np.repeat(loose, np.diff(hair.layout.offsets))[:, None, None], every, motion.turns)


def _renewed(
    before: np.ndarray,
    places: Places,
    leaders: np.ndarray,
    points: np.ndarray,
    offsets: np.ndarray,
    turns: np.ndarray,
) -> Places:
    """Return what followers follow from now on: what they did, where that is simulated still; else what is near."""
    counts, owners = np.diff(offsets), np.repeat(np.arange(len(leaders)), np.diff(offsets))
    follows, leads = leaders != np.arange(len(leaders)), leaders == np.arange(len(leaders))
    followers, guides = np.flatnonzero(follows), np.flatnonzero(leads)
    good = ((places.points < 0) | leads[owners[places.points]]).all(axis=1)
    keeps = np.zeros(len(leaders), np.bool_)
    if len(before):
        begins = np.cumsum(counts[before]) - counts[before]
        keeps[before] = np.logical_and.reduceat(good, begins)
    keeps &= follows
    fresh = followers[~keeps[followers]]
    out = no_places(int(counts[followers].sum()))
    news = find_places(points, offsets, guides, fresh, turns) if len(fresh) else no_places(0)
    old, new = np.repeat(keeps[before], counts[before]), np.repeat(keeps[followers], counts[followers])
    for whole, kept, found in zip(out, places, news, strict=True):
        whole[new], whole[~new] = kept[old], found
    return out


def _on_axes(hair: HairModel, state: HairState, points: np.ndarray, velocities: np.ndarray) -> HairState:
    """Return the state with the axes of all strands where they are; pure."""
    axis, x, v = axis_of(hair.layout), copied(state.positions), copied(state.velocities)
    scatter(axis, points, x)
    scatter(axis, velocities.astype(v.dtype), v)
    return replace(state, positions=x, velocities=v)
