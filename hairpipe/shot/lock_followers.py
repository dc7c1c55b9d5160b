"""Strands of locks at the end of a frame, interpolated outside of bodies, and the errors of the interpolation.

Followers, interpolated from neighbouring guides.

A point moves with the guide points that it follows,

    x = sum_j w_j (x_j + Q_j o_j),   w_j = 1 / max(|o_j|, core)^2 over their sum,

with x_j a point of a guide, Q_j its rotation since rest (`groom/keys.py`) and o_j the offset from it when
the hair began to follow, rotated back to rest. So a rigid motion of hair stays rigid. Near the root the remaining
distance to the root is added. A hair is then smoothed where neighbouring points disagree, by the difference of its
bend from the bend when it began to follow, and its segment lengths are restored from the root on. Velocities are the
exact derivative, except in segments that have nearly collapsed.

The disagreement of a point, the rms distance of its predictions from their mean, estimates its error against a full
simulation: measured, the two have the same rms and a correlation of 0.7 to 0.85 over hairs (`measure_locks`).

Places of a follower among the guides: the guide points nearest to each of its points, and the offsets from them.

Hairs of a lock cross and slide along each other, so the neighbours of a hair change along it. Each of its points
follows the few nearest guide points, of any lock, when it begins to follow; if one of these guides becomes a follower,
the point restarts, not the whole hair. Compared with a hair that follows only its own guide, this halves the error
(`measure_locks`).
"""

from typing import NamedTuple

import numpy as np
from numba import get_num_threads, njit, prange
from scipy.spatial import KDTree

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.vec3 import cross, dot, length, minus, plus, put, row, scaled
from hairpipe.groom.interpolating import go_on, moved, pushed_out
from hairpipe.groom.keys import turned, turned_back
from hairpipe.shot.lock_guides import GuideMotion
from hairpipe.shot.shot import Frame
from hairpipe.solve.boundary import motion_of_roots
from hairpipe.strands.hair_model import HairModel
from hairpipe.strands.material import Material
from hairpipe.values import Strands
from hairpipe.values.hair import FOLLOWED, LockState, Places, no_places
from hairpipe.values.strand_arrays import points_of_strands

_LISTED = 24
"""Nearest places among which they are chosen: several are on one guide."""


def find_places(
    points: np.ndarray, offsets: np.ndarray, guides: np.ndarray, mine: np.ndarray, turns: np.ndarray
) -> Places:
    """Find the guide points of points from their positions; pure."""
    theirs = points_of_strands(guides, offsets)
    listed = min(_LISTED, len(theirs))
    near = KDTree(points[theirs]).query(points[mine], listed, workers=get_num_threads())[1].reshape(len(mine), listed)
    owners = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    out = no_places(len(mine))
    _choose(near, theirs, owners, out.counts, out.points)
    _look_back(points, offsets, turns, owners, mine, out)
    return out


def renewed(
    places: Places,
    before: np.ndarray,
    keeps: np.ndarray,
    interpolated: np.ndarray,
    points: np.ndarray,
    offsets: np.ndarray,
    turns: np.ndarray,
) -> Places:
    """Return the new places of followers: unchanged where all their guides remain guides, else the nearest; pure.

    places, before  previous places, and the strands that had them, ascending, (n,)
    keeps, interpolated  strands that may keep them, and those that are interpolated from now on: the others may be
                         followed, (S,) bool
    points, offsets, turns  as for `find_places`
    """
    owners = np.repeat(np.arange(len(interpolated)), np.diff(offsets))
    rows = points_of_strands(before, offsets)
    mine = np.flatnonzero(interpolated[owners])
    lost = interpolated[owners[places.points]] & (np.arange(FOLLOWED) < places.counts[:, None])
    stays = (keeps & interpolated)[owners[rows]] & ~lost.any(axis=1)
    kept = np.isin(mine, rows[stays])
    out = no_places(len(mine))
    news = no_places(0)
    if not kept.all():
        news = find_places(points, offsets, np.flatnonzero(~interpolated), mine[~kept], turns)
    for whole, was, found in zip(out, places, news, strict=True):
        whole[kept] = was[stays]
        whole[~kept] = found
    return out


def nearest_guides(strands: np.ndarray, places: Places, offsets: np.ndarray) -> np.ndarray:
    """Return the possible guides of strands, ordered by the number of their points that a strand follows; pure.

    strands  ascending, (n,); places  what their points follow; offsets  offsets of all strands, (S+1,) int32

    Returns (n, FOLLOWED) int32, filled up with the strand itself. A guide has as many segments as its followers.
    """
    nearest = np.repeat(strands[:, None], FOLLOWED, axis=1).astype(np.int32)
    counts = np.diff(offsets)
    begins = np.concatenate([[0], np.cumsum(counts[strands])])
    owners = np.repeat(np.arange(len(counts)), counts)
    _rank(places, owners, counts, strands, begins, nearest)
    return nearest


@inlined
def turn_at(offsets: np.ndarray, strand: int, point: int) -> int:
    """Return the segment whose rotation a point of a strand has: the one that ends at it, of a root the first."""
    return point if point == offsets[strand] else point - 1


@njit(cache=True, parallel=True)
def _choose(near, theirs, owners, counts, followed):
    """Write the nearest places on different guides, in place; near  places in order of distance, (F, listed)."""
    for i in prange(len(near)):
        chosen = 0
        for candidate in range(near.shape[1]):
            place = theirs[near[i, candidate]]
            taken = chosen == FOLLOWED
            for j in range(chosen):  # Several of the nearest points are on one guide: only the nearest of each counts.
                taken |= owners[followed[i, j]] == owners[place]
            if not taken:
                followed[i, chosen] = place
                chosen += 1
        counts[i] = chosen


@njit(cache=True, parallel=True)
def _rank(places, owners, counts, strands, begins, nearest):
    """Write the owners of most places of each strand, in place; of as many, the first strand."""
    for f in prange(len(strands)):
        rows = slice(begins[f], begins[f + 1])
        valid = np.arange(FOLLOWED) < places.counts[rows].reshape(-1, 1)
        followed = places.points[rows].reshape(-1)[valid.reshape(-1)]
        guides = np.sort(owners[followed])  # Sorted: each guide is one run, ties go to the lower number.
        times = np.zeros(FOLLOWED, np.int64)
        first = 0
        while first < len(guides):
            guide = guides[first]
            end = first
            while end < len(guides) and guides[end] == guide:
                end += 1
            if counts[guide] == counts[strands[f]]:
                _insert(guide, end - first, nearest[f], times)
            first = end


@njit(cache=True)
def _insert(guide, count, guides, times):
    """Insert a guide where it belongs among those of most places, in place."""
    at = FOLLOWED
    while at > 0 and count > times[at - 1]:  # Behind equals: the guide of the lower number, which came first, stays.
        at -= 1
    for k in range(FOLLOWED - 1, at, -1):
        guides[k], times[k] = guides[k - 1], times[k - 1]
    if at < FOLLOWED:
        guides[at], times[at] = guide, count


@njit(cache=True, parallel=True)
def _look_back(points, offsets, turns, owners, mine, places):
    """Write the ways from the places and the bends, turned back, in place."""
    for i in prange(len(mine)):
        p = mine[i]
        strand = owners[mine[i]]
        x = row(points, p)
        for j in range(places.counts[i]):
            place = np.int64(places.points[i, j])
            turn = turn_at(offsets, owners[place], place)
            put(places.offsets[:, j], i, turned_back(turns, turn, minus(x, row(points, place))))
        if p > offsets[strand]:
            bend = minus(row(points, p - 1), x)
            if p + 1 < offsets[strand + 1]:
                bend = plus(bend, minus(row(points, p + 1), x))
            nearest = np.int64(places.points[i, 0])  # Turned back by the guide that `_smooth` will turn it with.
            put(places.bends, i, turned_back(turns, turn_at(offsets, owners[nearest], nearest), bend))


_CORE = 3e-4
"""Nearer places count alike, for hair of the default diameter [m]: two hairs touch."""
_ROOT = 0.25
"""Share of a hair's length over which it goes from where its root is to where its guides take it."""
_PASSES = 2
"""Of smoothing."""
_SHORTEST = 0.5
"""Way over the length of its segment below which the segment turns no faster than the way would at this length."""


def interpolated(
    followers: np.ndarray,
    places: Places,
    guides: GuideMotion,
    offsets: np.ndarray,
    rest: np.ndarray,
    roots: tuple[np.ndarray, np.ndarray],
    diameter: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions and velocities of followers, (F, 3), and the disagreement of their guides, (n,); pure."""
    points, velocities = np.empty((len(places.points), 3)), np.empty((len(places.points), 3))
    disagreement = np.empty(len(followers))
    begins = np.concatenate([[0], np.cumsum(np.diff(offsets)[followers])])
    owners = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets)).astype(np.int32)
    about = offsets, rest, owners, begins, _CORE * (diameter / Material().diameter)
    _interpolate(followers, places, guides, about, roots, points, velocities, disagreement)
    return points, velocities, disagreement


@njit(cache=True, parallel=True, error_model="numpy")
def _interpolate(followers, places, guides, about, roots, points, velocities, disagreement):
    offsets, rest, owners, begins, core = about
    motions, rates = roots
    for f in prange(len(followers)):
        begin = begins[f]
        end = begins[f + 1]
        first = offsets[followers[f]]
        x = points[begin:end]
        v = velocities[begin:end]
        total = 0.0
        for i in range(begin, end):
            total += _follow(places, guides, (owners, offsets, core), i, begin, x, v)
        disagreement[f] = np.sqrt(total / (end - begin))
        root, rate = moved(motions, followers[f], row(rest, first)), moved(rates, followers[f], row(rest, first))
        _lead_from_root(x, v, root, rate)
        for _ in range(_PASSES):
            _smooth(places, guides, owners, offsets, begin, x, v)
        for k in range(1, end - begin):
            l = length(minus(row(rest, first + k), row(rest, first + k - 1)))
            before, speed = row(x, k - 1), row(v, k - 1)
            way, change = minus(row(x, k), before), minus(row(v, k), speed)
            # A way that has nearly vanished, where places fold, turns at any speed: hair does not.
            change = scaled(min(length(way) / (_SHORTEST * l), 1.0), change)
            at, goes = go_on(before, speed, l, way, change)
            put(x, k, at)
            put(v, k, goes)


@njit(cache=True, error_model="numpy")
def _follow(places, guides, about, i, begin, x, v):
    """Put point i where its places take it; return the mean square of what they disagree by [m^2]."""
    owners, offsets, core = about
    weights, square = 0.0, 0.0
    there = to = speed = (0.0, 0.0, 0.0)
    for j in range(places.counts[i]):
        p = np.int64(places.points[i, j])
        offset = (
            np.float64(places.offsets[i, j, 0]),
            np.float64(places.offsets[i, j, 1]),
            np.float64(places.offsets[i, j, 2]),
        )
        k = turn_at(offsets, owners[p], p)
        way = turned(guides.turns, k, offset)
        y = plus(row(guides.points, p), way)
        dy = plus(row(guides.velocities, p), cross(row(guides.spins, k), way))
        if j == 0:  # Relative to the nearest: in squares of world coordinates the difference loses its digits.
            there = y
        w = 1.0 / max(dot(offset, offset), core * core)
        off = minus(y, there)
        weights = weights + w
        square = square + w * dot(off, off)
        to, speed = plus(to, scaled(w, off)), plus(speed, scaled(w, dy))
    mean = scaled(1.0 / weights, to)
    put(x, i - begin, plus(there, mean))
    put(v, i - begin, scaled(1.0 / weights, speed))
    return max(square / weights - dot(mean, mean), 0.0)  # Not negative: rounding of a variance.


@njit(cache=True)
def _lead_from_root(x, v, root, rate):
    """Shift a hair to its root, less and less along it, in place."""
    shift, change = minus(root, row(x, 0)), minus(rate, row(v, 0))
    for k in range(len(x)):
        left = max(1.0 - k / (_ROOT * (len(x) - 1)), 0.0)
        put(x, k, plus(row(x, k), scaled(left * left, shift)))
        put(v, k, plus(row(v, k), scaled(left * left, change)))


@njit(cache=True)
def _smooth(places, guides, owners, offsets, begin, x, v):
    """Move the points of a hair by a quarter of what its bends differ from those when it began to follow, in place."""
    last = len(x) - 1
    # Old places of the point before are kept, so that the result does not depend on the direction of the pass.
    before, went = row(x, 0), row(v, 0)
    for k in range(1, last + 1):
        i = begin + k
        here = row(x, k)
        goes = row(v, k)
        p = np.int64(places.points[i, 0])
        s = turn_at(offsets, owners[p], p)
        bend = (np.float64(places.bends[i, 0]), np.float64(places.bends[i, 1]), np.float64(places.bends[i, 2]))
        own = turned(guides.turns, s, bend)
        differs = minus(minus(before, here), own)
        turns = minus(minus(went, goes), cross(row(guides.spins, s), own))
        share = 0.5
        if k < last:
            differs, turns = plus(differs, minus(row(x, k + 1), here)), plus(turns, minus(row(v, k + 1), goes))
            share = 0.25
        put(x, k, plus(here, scaled(share, differs)))
        put(v, k, plus(goes, scaled(share, turns)))
        before, went = here, goes


class Followed(NamedTuple):
    """All strands at the end of a frame.

    points, velocities  as shown: followers interpolated, the others simulated [m], [m/s], (P, 3)
    interpolated        compared strands interpolated, too [m], (P, 3)
    disagreement        disagreement of the guides of each strand, rms over its points [m], (S,)
    pushed              displacement of each strand by bodies, rms [m], (S,)
    errors              error of each compared strand against its own simulation, rms [m], (S,)
    """

    points: np.ndarray
    velocities: np.ndarray
    interpolated: np.ndarray
    disagreement: np.ndarray
    pushed: np.ndarray
    errors: np.ndarray


def follow(hair: HairModel, known: LockState, motion: GuideMotion, frame: Frame, thickness: float) -> Followed:
    """Interpolate followers and compared strands, and push them out of bodies to a distance [m]; pure."""
    offsets = hair.layout.offsets
    disagreement = np.zeros(len(known.roles))
    strands = np.flatnonzero(known.interpolated)
    if not len(strands):
        return Followed(motion.points, motion.velocities, motion.points, *[disagreement] * 3)
    roots = motion_of_roots(frame.drivers[1], hair.groom)
    rows = points_of_strands(strands, offsets)
    points = motion.points.copy()
    velocities = motion.velocities.copy()
    points[rows], velocities[rows], disagreement[strands] = interpolated(
        strands, known.places, motion, offsets, hair.groom.points, roots, hair.diameter
    )
    surfaces = [after for _, after in frame.surfaces]
    parts = [after for _, after in frame.parts]
    inside = Strands(points, velocities, offsets, hair.diameter)
    outside = pushed_out(inside, known.interpolated, surfaces, parts, thickness, frame.frame_dt)
    pushed = distances(outside.points, points, offsets)
    errors = distances(outside.points, motion.points, offsets)
    follows = np.repeat(known.follows, np.diff(offsets))[:, None]
    shown = np.where(follows, outside.points, motion.points)
    speeds = np.where(follows, outside.velocities, motion.velocities)
    return Followed(shown, speeds, outside.points, disagreement, pushed, errors)


def distances(points: np.ndarray, others: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the rms distance over the points of each strand [m], (S,); pure."""
    return np.sqrt(np.add.reduceat(((points - others) ** 2).sum(axis=1), offsets[:-1]) / np.diff(offsets))
