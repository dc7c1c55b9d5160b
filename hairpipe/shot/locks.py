"""A frame of hair in locks: guides are simulated, followers interpolated; then strands get new roles.

Other code uses locks by this module, and by the questions that `LockState` answers. A strand is a guide, a follower, or
simulated for a while outside its lock: audited, released because of a large error, or tried for its return.

The audit simulates some locks, in turn, in full, and compares the strands with their interpolation. It is part of the
run, so audited hairs have the same surroundings as guides. It lasts as many frames as a connection must, and selects
each lock once in `1 / audit` audits; a lock whose error is too large at its end is dissolved. The audit does not
measure the errors of guides themselves: a guide of many strands has other contacts with guides than many hairs would.

A lock is audited only if its guide has moved, in the frame of its root, by more than the tolerance since the end of the
last audit at which it had. An audited hair has another equilibrium than its interpolation, and disturbs its
neighbours, so hair at rest would never stay at rest; and if guides do not move, the error does not grow.

A strand that is simulated again stands up: its particles are about its axis as they are at rest. Connections of new
followers are moved to their guides.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numba import njit, prange

from hairpipe.contact.stiction import Connections
from hairpipe.errors import BadInput
from hairpipe.geometry.segments import ages_of, key_of
from hairpipe.geometry.simd import copied
from hairpipe.geometry.vec3 import cross, minus, mix, plus, row
from hairpipe.groom.keys import turned, turns_since
from hairpipe.laws.settings import Locks
from hairpipe.shot.build import own_interactions
from hairpipe.shot.lock_followers import Followed, distances, follow, nearest_guides, renewed
from hairpipe.shot.lock_guides import GuideMotion, guides_of, joined, take_guides
from hairpipe.shot.settings import Scene
from hairpipe.shot.shot import Frame
from hairpipe.solve.boundary import clamp_at, held_tips, motion_of_roots
from hairpipe.strands.hair_model import HairModel
from hairpipe.strands.layout import axis_of
from hairpipe.values import Strands
from hairpipe.values.groom import Driver
from hairpipe.values.hair import (
    AUDITED,
    FOLLOWER,
    GUIDE,
    RELEASED,
    TRIED,
    Audit,
    HairState,
    LockState,
    Places,
    no_locks,
)


def to_audit(leaders: np.ndarray, share: float, turn: int) -> np.ndarray:
    """Return which followers are audited in a turn, (S,) bool; pure."""
    follows = leaders != np.arange(len(leaders))
    if share == 0.0 or not follows.any():
        return np.zeros(len(leaders), np.bool_)
    guides = np.unique(leaders[follows])
    period = min(round(1.0 / share), max(len(guides) // 2, 4))
    return follows & np.isin(leaders, guides[turn % period :: period])


def about_roots(points: np.ndarray, offsets: np.ndarray, motions: np.ndarray) -> np.ndarray:
    """Return points in the frames of their roots, (P, 3) float32 [m]; motions  x -> R x + t, (S, 3, 4); pure."""
    counts = np.diff(offsets)
    turns = np.repeat(motions[:, :, :3], counts, axis=0)
    return np.einsum("pij,pi->pj", turns, points - np.repeat(motions[:, :, 3], counts, axis=0)).astype(np.float32)


def moved_since(
    reference: np.ndarray, here: np.ndarray, offsets: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Find the strands that have moved by more than a tolerance [m], rms, (S,) bool; they get a new reference; pure."""
    moved = distances(here, reference, offsets) > tolerance
    return moved, np.where(np.repeat(moved, np.diff(offsets))[:, None], here, reference)


def audited_locks(guides: np.ndarray, errors: np.ndarray) -> tuple[Audit, np.ndarray]:
    """Return the errors of audited locks, and the lock of each strand among these, (A,); pure."""
    _, locks, hairs = np.unique(guides, return_inverse=True, return_counts=True)
    squares = np.bincount(locks, errors.astype(float) ** 2, len(hairs))
    return Audit(np.sqrt(squares / hairs), hairs), locks


def back_in(leaders: np.ndarray, tried: np.ndarray, nearest: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the guide of every strand after trials, (S,) int32, and the new guides, ascending; pure."""
    near = nearest[:, 0] != tried
    tried, nearest = tried[near], nearest[near]
    out = leaders.copy()
    _seat(tried, nearest, np.bincount(leaders, minlength=len(leaders)), most, out)
    return out, tried[out[tried] == tried][::most]


@njit(cache=True)
def _seat(hairs, nearest, sizes, most, leaders):
    """Give hairs the first guide that has room, one after the other, in place."""
    for i in range(len(hairs)):  # One after another, by number: each takes room from those after it.
        for guide in nearest[i]:
            if guide != hairs[i] and sizes[guide] < most:
                leaders[hairs[i]] = guide
                sizes[guide] += 1
                break


def inherited(
    connections: Connections, ages: np.ndarray, leaders: np.ndarray, offsets: np.ndarray, closest: int
) -> tuple[Connections, np.ndarray]:
    """Return the connections of guides, in order, and their ages in frames, (m,) int32; pure.

    connections  connections of strands simulated so far; ages  their ages in frames, (n,) int32
    leaders      new guide of every strand, (S,) int32; offsets  offsets of the strands, (S+1,) int32
    closest      maximum number of connections of a segment: a guide's own take precedence, then the oldest

    A connection moves to the same segment of the guide, which has as many segments; connections of a guide to itself
    are deleted.
    """
    strands = np.searchsorted(offsets, connections.segments, side="right") - 1
    theirs = leaders[strands]
    segments = connections.segments + (offsets[theirs] - offsets[strands])
    swapped = segments[:, 0] > segments[:, 1]
    segments = np.where(swapped[:, None], segments[:, ::-1], segments).astype(np.int32)
    fractions = np.where(swapped[:, None], connections.fractions[:, ::-1], connections.fractions)
    own = (theirs == strands).all(axis=1)
    apart = own | (theirs[:, 0] != theirs[:, 1])
    order = np.lexsort((-ages, ~own))
    order = order[apart[order]]
    _, firsts = np.unique(key_of(segments[order]), return_index=True)
    order = order[np.sort(firsts)]
    kept = order[_with_room(segments[order], np.zeros(offsets[-1], np.int64), closest)]
    kept = kept[np.argsort(key_of(segments[kept]), kind="stable")]
    return Connections(segments[kept], fractions[kept]), ages[kept]


@njit(cache=True)
def _with_room(segments, taken, most):
    """Mark the pairs, one after the other, for which both segments have room, (n,) bool."""
    kept = np.empty(len(segments), np.bool_)
    for k in range(len(segments)):
        a, b = segments[k]
        kept[k] = taken[a] < most and taken[b] < most  # In the order of priority: those that come first take the room.
        taken[a] += kept[k]
        taken[b] += kept[k]
    return kept


def leaving(
    known: LockState, found: Followed, locks: Locks, ends: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray, Audit | None]:
    """Return leaders, and strands that leave their lock or are out, after errors of followers and of an ended audit."""
    loose = known.follows & (np.maximum(found.disagreement, found.pushed) > locks.tolerance)
    leaders = np.where(loose, np.arange(len(loose), dtype=np.int32), known.leaders)
    out = known.released | loose
    dissolved = np.zeros(len(loose), np.bool_)
    audited = known.roles == AUDITED
    if not (ends and audited.any()):
        return leaders, out, dissolved, None
    audit, lock = audited_locks(known.guides[audited], found.errors[audited].astype(np.float32))
    dissolved[audited] = ~(audit.errors <= locks.tolerance)[lock]
    kept = audited & ~dissolved
    leaders[kept] = leaders[known.guides[kept]]
    return leaders, out | dissolved, dissolved, audit


def regrouped(
    known: LockState,
    connections: Connections,
    ages: np.ndarray,
    found: Followed,
    offsets: np.ndarray,
    roots: np.ndarray,
    locks: Locks,
    closest: int,
) -> tuple[LockState, Connections]:
    """Return the state of locks after a frame, with the places before it, and the connections of guides; pure."""
    strands = np.arange(len(known.guides), dtype=np.int32)
    owners = np.searchsorted(offsets, connections.segments, side="right") - 1
    ends = known.since + 1 >= locks.after
    leaders, out, dissolved, audit = leaving(known, found, locks, ends)
    # What the others stick to must last again before they follow again by that.
    ages = np.where(dissolved[owners].any(axis=1), 0, ages).astype(np.int32)
    if ends:
        tried = (known.roles == TRIED) & (found.errors <= locks.tolerance)
        leaders, leading = back_in(leaders, *_find_nearest(known, tried, offsets), locks.most)
        out[leading] = False

    compared = known.compared & (not ends)
    occupied = np.where((known.roles == AUDITED) & compared, leaders[known.guides], leaders)
    free = ~(compared | (leaders != strands))[owners].any(axis=1)
    ties = joined(leaders, occupied, connections.segments[free], ages[free], offsets, locks)
    leaders = guides_of(ties, leaders, found.points, offsets)
    out &= np.bincount(leaders, minlength=len(leaders))[leaders] == 1
    guides = np.where(out | compared, leaders[known.guides], leaders)

    sample = np.zeros(len(strands), np.bool_)
    reference = known.reference
    if ends:
        here = about_roots(found.points, offsets, roots)
        moved, reference = moved_since(reference, here, offsets, locks.tolerance)
        sample = to_audit(leaders, locks.audit, known.turn + 1) & moved[leaders]
    now = (known.roles, TRIED if ends else RELEASED, AUDITED, FOLLOWER)
    roles = np.select([compared, out, sample, leaders != strands], now, GUIDE)
    connections, ages = inherited(connections, ages, np.where(sample, strands, leaders), offsets, closest)
    disagreement = found.disagreement[roles == FOLLOWER].astype(np.float32)
    turn = known.turn + ends
    since = 0 if ends else known.since + 1
    state = LockState(roles, guides, ages, known.places, reference, disagreement, audit, turn=turn, since=since)
    return state, connections


def _find_nearest(known: LockState, chosen: np.ndarray, offsets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return strands on trial, (n,), of a mask, (S,) bool, and the guides near them, see `nearest_guides`."""
    among = np.flatnonzero(known.interpolated)
    rows = np.repeat(chosen[among], np.diff(offsets)[among])
    strands = np.flatnonzero(chosen)
    return strands, nearest_guides(strands, Places(*(values[rows] for values in known.places)), offsets)


def motion_along(hair: HairModel, points: np.ndarray, velocities: np.ndarray, driver: Driver) -> GuideMotion:
    """Return the motion of all strands, with axes at points [m], (P, 3), and velocities [m/s]; pure."""
    strands = Strands(points, velocities, hair.layout.offsets, hair.diameter)
    turns = turns_since(hair.groom.points, strands, *motion_of_roots(driver, hair.groom))
    return GuideMotion(points, velocities, turns.turns, turns.spins)


def stand_up(hair: HairModel, state: HairState, motion: GuideMotion, active: np.ndarray, driver: Driver) -> HairState:
    """Return the state with the particles of some strands, (S,) bool, rebuilt about their moving axes; pure.

    Particles off an axis rotate with its segments, the twist transported from the root; held particles move with the
    root. Accelerations and tensions are unknown: strands restart.
    """
    layout = hair.layout
    names = ("positions", "velocities", "accelerations", "tensions")
    arrays = {name: copied(getattr(state, name)) for name in names}
    clamp = clamp_at(driver, hair.groom, hair.rest, layout)
    held = clamp.positions, clamp.velocities
    _stand(axis_of(layout), hair.rest, active, motion, held, tuple(arrays.values()))
    return replace(state, **arrays, fresh=state.fresh | active[layout.strands])


@njit(cache=True, parallel=True)
def _stand(axis, rest, active, motion, held, particles):
    """Write the rows of strands that stand up, in place: those between two points go with the middle of these."""
    (held_x, held_v), (x, v, accelerations, tensions) = held, particles
    for block in prange(len(axis.first) - 1):
        first = axis.first[block]
        end = axis.first[block + 1]
        for lane in range(axis.strands.shape[1]):
            if active[axis.strands[block, lane]]:
                accelerations[first:end, :, lane] = 0.0  # Nothing is known of either: the strand restarts.
                tensions[first:end, :, lane] = 0.0
                x[first : first + axis.root, :, lane] = held_x[block, : axis.root, :, lane]
                v[first : first + axis.root, :, lane] = held_v[block, : axis.root, :, lane]
                _place_beside(axis, rest, motion, block, lane, x, v)


@njit(cache=True)
def _place_beside(axis, rest, motion, block, lane, x, v):
    """Write the rows of one strand from the root on, in place."""
    first = axis.first[block] + axis.root
    end = axis.first[block + 1]
    stride = axis.stride
    begin = axis.offsets[axis.strands[block, lane]]
    last = axis.offsets[axis.strands[block, lane] + 1] - 1
    for p in range(first, end):  # A row between two points stands about their middle, turned as the segment is.
        k = min((p - first) // stride, last - begin)
        on = k * stride == p - first
        after = min(begin + k + 1, last)
        share = 0.0 if on or after == begin + k else 0.5
        middle = mix(row(motion.points, begin + k), row(motion.points, after), share)
        speed = mix(row(motion.velocities, begin + k), row(motion.velocities, after), share)
        was = _of_lane(rest, first + k * stride, lane)
        then = _of_lane(rest, first + (after - begin) * stride, lane)
        segment = min(begin + k, last - 1)
        way = turned(motion.turns, segment, minus(_of_lane(rest, p, lane), mix(was, then, share)))
        at = plus(middle, way)
        goes = plus(speed, cross(row(motion.spins, segment), way))
        for c in range(3):
            x[p, c, lane], v[p, c, lane] = at[c], goes[c]


@njit(cache=True)
def _of_lane(lanes, p, lane):
    return lanes[p, 0, lane], lanes[p, 1, lane], lanes[p, 2, lane]


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
