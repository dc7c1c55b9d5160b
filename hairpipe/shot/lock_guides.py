"""The hairs that are simulated, as a model of their own: taken out of all hairs, and put back among them.

Formation of locks: lasting connections of stiction join their hairs, the pairs with most connections first.

In steady motion connections are nearly permanent, so hairs with many common connections move together. One hair of
each lock, its guide, is simulated; the others are interpolated (`lock_followers.py`).
"""

from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.groom.keys import turns_since
from hairpipe.laws.settings import Locks
from hairpipe.solve.boundary import motion_of_roots
from hairpipe.strands.hair_model import HairModel
from hairpipe.strands.interface import StrandModel, kind_of
from hairpipe.strands.layout import Layout, lay_out
from hairpipe.values import Ends, Strands
from hairpipe.values.groom import Driver
from hairpipe.values.hair import HairState
from hairpipe.values.strand_arrays import points_of_strands, take

_BY_LANE = ("positions", "velocities", "accelerations", "tensions", "fresh")
"""Arrays of a state with a lane for every strand."""


class GuideMotion(NamedTuple):
    """Strands at a frame; rows are points of the groom, of followers 0.

    points, velocities  [m], [m/s], (P, 3)
    turns               rotations of segments since rest, (P, 3, 3)
    spins               angular velocities of segments [rad/s], (P, 3)
    """

    points: np.ndarray
    velocities: np.ndarray
    turns: np.ndarray
    spins: np.ndarray


@dataclass(frozen=True, eq=False)
class Guides:
    """The guides as a model of hair of their own.

    whole    model of all strands
    hair     model of the guides
    strands  strands that are guides, ascending, (G,)
    points   points of the groom that belong to guides, (Pg,)
    numbers  index of each point of the groom among these, -1 if absent, (P,)
    """

    whole: HairModel
    hair: HairModel
    strands: np.ndarray
    points: np.ndarray
    numbers: np.ndarray

    def drivers_of(self, drivers: tuple[Driver, Driver]) -> tuple[Driver, Driver]:
        """Return the drivers of these roots at two frames, from those of all; pure."""
        before, after = (
            Ends(*(getattr(driver, of.name)[self.strands] for of in fields(Ends)))
            if isinstance(driver, Ends)
            else driver
            for driver in drivers
        )
        return before, after

    def state_of(self, state: HairState) -> HairState:
        """Return the state of these strands; pure."""
        layouts = self.whole.layout, self.hair.layout
        rows = {name: _taken(getattr(state, name), *layouts, self.strands) for name in _BY_LANE}
        lengths = state.inverse_lengths
        return replace(
            state,
            **rows,
            inverse_lengths=None if lengths is None else _taken(lengths, *layouts, self.strands),
            stuck=self.numbers[state.stuck].astype(np.int32),
            touching=None if state.touching is None else state.touching.renumbered(self.numbers),
            shear=None if state.shear is None else state.shear.renumbered(self.numbers),
        )

    def put(self, state: HairState, moved: HairState) -> HairState:
        """Return the state of all, with that of these strands as it has become; pure."""
        layouts = self.whole.layout, self.hair.layout
        rows = {name: _put(getattr(state, name), getattr(moved, name), *layouts, self.strands) for name in _BY_LANE}
        stuck = self.points[moved.stuck].astype(np.int32)
        impulses = None
        if moved.impulses is not None:
            impulses = np.zeros((len(self.whole.groom.ids), 3))
            impulses[self.strands] = moved.impulses
        touching = None if moved.touching is None else moved.touching.renumbered(self.points)
        shear = None if moved.shear is None else moved.shear.renumbered(self.points)
        kept = {"stuck": stuck, "touching": touching, "shear": shear, "impulses": impulses}
        return replace(moved, **rows, **kept, inverse_lengths=state.inverse_lengths)

    def motion_of(self, moved: HairState, driver: Driver) -> GuideMotion:
        """Return the motion of these strands at a frame, at the points of all; pure."""
        groom, layout = self.hair.groom, self.hair.layout
        points = layout.axis(moved.positions)
        velocities = layout.axis(moved.velocities).astype(np.float64)
        roots = (motions[self.strands] for motions in motion_of_roots(driver, self.whole.groom))
        turns = turns_since(groom.points, Strands(points, velocities, layout.offsets, self.hair.diameter), *roots)
        out = []
        for values in (points, velocities, turns.turns, turns.spins):
            out.append(np.zeros((len(self.numbers), *values.shape[1:])))
            out[-1][self.points] = values
        return GuideMotion(*out)


def take_guides(whole: HairModel, leaders: np.ndarray) -> Guides:
    """Build the model of the guides of strands, (S,) int32, from that of all; pure."""
    layout, groom = whole.layout, whole.groom
    strands = np.flatnonzero(leaders == np.arange(len(leaders)))
    points = points_of_strands(strands, layout.offsets)
    numbers = np.full(layout.offsets[-1], -1, np.int32)
    numbers[points] = np.arange(len(points))
    some = take(groom, strands)
    part = lay_out(some.offsets, layout.shape, layout.dtype)
    hairs = np.bincount(leaders, minlength=len(leaders))[strands]
    widths = np.repeat(np.sqrt(hairs), np.diff(some.offsets))
    model = _model_of(whole, part, strands)
    rest = _taken(whole.rest, layout, part, strands)
    diameters = None if whole.diameters is None else whole.diameters[points]
    shared = {"in_double": whole.in_double, "diameters": diameters}
    guides = HairModel(some, part, model, rest, whole.diameter, widths, (whole, numbers), **shared)
    return Guides(whole, guides, strands, points, numbers)


def _model_of(whole: HairModel, part: Layout, strands: np.ndarray) -> StrandModel:
    """Return the model of some strands: its arrays have a row for every particle, or for every strand."""
    layout = whole.layout
    changes = {"first": part.first}
    names: tuple[str, ...] = kind_of(whole.model).model._fields  # type: ignore[attr-defined]
    for name in names:
        values = getattr(whole.model, name)
        if name != "first":
            changes[name] = _taken(values, layout, part, strands)
    return whole.model._replace(**changes)


def _where(layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Return the block and the lane of every strand, (S,) each."""
    blocks, lanes = (np.empty(len(layout.offsets) - 1, np.int64) for _ in range(2))
    used = np.nonzero(~layout.idle)
    blocks[layout.strands[used]], lanes[layout.strands[used]] = used
    return blocks, lanes


def _firsts(values: np.ndarray, whole: Layout, part: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Return the first rows of blocks of two layouts, in arrays of particles or of strands like values of the first."""
    if len(values) == whole.first[-1]:
        return whole.first, part.first
    return np.arange(whole.blocks + 1), np.arange(part.blocks + 1)


def _taken(values: np.ndarray, whole: Layout, part: Layout, strands: np.ndarray) -> np.ndarray:
    """Return what some strands have of values of particles or strands, (rows or blocks, ..., W); pure."""
    of_whole, of_part = _firsts(values, whole, part)
    out = np.empty((of_part[-1], *values.shape[1:]), values.dtype)
    _take(_flat(values), of_whole, *_where(whole), _flat(out), of_part, strands[part.strands])
    return out


def _put(values: np.ndarray, changed: np.ndarray, whole: Layout, part: Layout, strands: np.ndarray) -> np.ndarray:
    """Return values of all particles or strands, with what some strands have now; pure."""
    of_whole, of_part = _firsts(values, whole, part)
    out = values.copy()
    _give(_flat(changed), of_part, strands[part.strands], part.idle, _flat(out), of_whole, *_where(whole))
    return out


def _flat(values: np.ndarray) -> np.ndarray:
    """View an array of lanes as rows of one number after another, (rows, k, W)."""
    return values.reshape(len(values), -1, values.shape[-1])


@njit(cache=True, parallel=True)
def _take(source, firsts, blocks, lanes, out, first, strands):
    for block in prange(len(first) - 1):
        for lane in range(strands.shape[1]):
            begin = firsts[blocks[strands[block, lane]]]
            theirs = lanes[strands[block, lane]]
            for row in range(first[block + 1] - first[block]):
                for c in range(out.shape[1]):
                    out[first[block] + row, c, lane] = source[begin + row, c, theirs]


@njit(cache=True, parallel=True)
def _give(source, first, strands, idle, out, firsts, blocks, lanes):
    for block in prange(len(first) - 1):
        for lane in range(strands.shape[1]):
            if not idle[block, lane]:  # An idle lane repeats a strand: its rows are written once only.
                begin = firsts[blocks[strands[block, lane]]]
                theirs = lanes[strands[block, lane]]
                for row in range(first[block + 1] - first[block]):
                    for c in range(out.shape[1]):
                        out[begin + row, c, theirs] = source[first[block] + row, c, lane]


def joined(
    leaders: np.ndarray,
    occupancy: np.ndarray,
    segments: np.ndarray,
    ages: np.ndarray,
    offsets: np.ndarray,
    locks: Locks,
) -> np.ndarray:
    """Return the lock of every strand, named by one of its guides, (S,) int32; pure.

    leaders    the guide of every strand, a guide's own for itself, (S,) int32
    occupancy  the same, with the previous guide for strands that will follow again, (S,) int32
    segments   connected segments of guides, (n, 2) int32; ages  number of frames of each connection, (n,)
    offsets    of the points of strands, (S+1,) int32

    Guides with equal numbers of segments are joined if the share `part` of these have lasting connections, up to the
    maximum size of a lock; ties are resolved by strand index.
    """
    lasted = segments[ages >= locks.after]
    strands = np.searchsorted(offsets, lasted, side="right") - 1
    strands = np.sort(strands[strands[:, 0] != strands[:, 1]], axis=1)
    counts = np.diff(offsets) - 1
    strands = strands[counts[strands[:, 0]] == counts[strands[:, 1]]]
    pairs, times = np.unique(strands, axis=0, return_counts=True)
    enough = times >= locks.part * counts[pairs[:, 0]]
    pairs, times = pairs[enough], times[enough]
    order = np.argsort(-times, kind="stable")
    sizes = np.bincount(occupancy, minlength=len(occupancy))
    return _unite(pairs[order], leaders, sizes, locks.most)


@njit(cache=True)
def _unite(pairs, leaders, sizes, most):
    """Join pairs of guides, (n, 2), one after the other; return the lock of every strand, (S,) int32."""
    parents = np.arange(len(leaders)).astype(np.int32)
    for k in range(len(pairs)):
        a, b = _root(parents, pairs[k, 0]), _root(parents, pairs[k, 1])
        if a != b and sizes[a] + sizes[b] <= most:  # What would make a lock too large is left out.
            first = min(a, b)  # The lower number names the lock, whatever the order in which it grew.
            second = max(a, b)
            parents[second] = first
            sizes[first] += sizes[second]
    locks = np.empty_like(leaders)
    for s in range(len(leaders)):
        locks[s] = _root(parents, leaders[s])
    return locks


@njit(cache=True)
def _root(parents, s):
    while parents[s] != s:
        parents[s] = parents[parents[s]]  # Path halving keeps the trees flat.
        s = parents[s]
    return s


def guides_of(locks: np.ndarray, leaders: np.ndarray, points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the guide of every strand, (S,) int32: the guide in its lock that is nearest to the mean; pure.

    locks    lock of each strand, as named by `joined`, (S,); leaders  previous guides, (S,) int32
    points   points of all strands [m], (P, 3)

    A guide is one of the strands simulated so far and keeps its own state: nothing is averaged.
    """
    out = leaders.copy()
    _choose(np.argsort(locks, kind="stable"), locks, leaders, points, offsets, out)
    return out


@njit(cache=True)
def _choose(order, locks, leaders, points, offsets, out):
    begin = 0
    while begin < len(order):
        end = begin
        while end < len(order) and locks[order[end]] == locks[order[begin]]:
            end += 1
        members = order[begin:end]
        fresh = False
        for s in members:
            fresh |= leaders[s] != leaders[members[0]]
        if fresh:  # Only locks that have grown choose again: a guide is changed as seldom as possible.
            best = _nearest_to_mean(members, leaders, points, offsets)
            for s in members:
                out[s] = best
        begin = end


@njit(cache=True)
def _nearest_to_mean(members, leaders, points, offsets):
    count = offsets[members[0] + 1] - offsets[members[0]]
    mean = np.zeros((count, 3))
    for s in members:
        for k in range(count):
            for c in range(3):
                mean[k, c] += points[offsets[s] + k, c] / len(members)
    best = members[0]
    least = np.inf
    for s in members:
        far = 0.0
        for k in range(count):
            for c in range(3):
                far += (points[offsets[s] + k, c] - mean[k, c]) ** 2
        if leaders[s] == s and far < least:  # Only a guide has a simulated state of its own.
            best, least = s, far
    return best
