"""Places of a follower among the guides: the guide points nearest to each of its points, and the offsets from them.

Hairs of a lock cross and slide along each other, so the neighbours of a hair change along it. Each of its points
follows the few nearest guide points, of any lock, when it begins to follow; if one of these guides becomes a follower,
the point restarts, not the whole hair. Compared with a hair that follows only its own guide, this halves the error
(`measure_locks`).
"""

from typing import NamedTuple

import numpy as np
from numba import get_num_threads, njit, prange
from scipy.spatial import KDTree

from hairpipe.groom.keys.key_turns import turned_back
from hairpipe.groom.resampling import put
from hairpipe.groom.strand_arrays import points_of_strands
from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import minus, plus, row

FOLLOWED = 4
"""Places that a point follows, each on a guide of its own."""
_LISTED = 24
"""Nearest places among which they are chosen: several are on one guide."""


class Places(NamedTuple):
    """Guide points of followers; rows are the points of followers in the order of the groom.

    points   guide points that a point follows, the nearest first, -1: no more, (F, 4) int32
    offsets  offsets of the point from them, rotated back to the guide at rest [m], (F, 4, 3) float32
    bends    twice the vector from the point to the middle of its two neighbours, at the tip to the previous point;
             rotated back like the first offset [m], (F, 3) float32
    """

    points: np.ndarray
    offsets: np.ndarray
    bends: np.ndarray


def no_places(points: int) -> Places:
    """Give so many points nothing to follow."""
    offsets = np.zeros((points, FOLLOWED, 3), np.float32)
    bends = np.zeros((points, 3), np.float32)
    return Places(np.full((points, FOLLOWED), -1, np.int32), offsets, bends)


def find_places(
    points: np.ndarray, offsets: np.ndarray, guides: np.ndarray, mine: np.ndarray, turns: np.ndarray
) -> Places:
    """Find the guide points of points from their positions; pure.

    points     points of all strands [m], (P, 3); offsets  offsets of the strands, (S+1,) int32
    guides     simulated strands, (G,); mine  points of others that begin to follow, (F,)
    turns      rotations of guide segments since rest, at the first point of each segment, (P, 3, 3)
    """
    theirs = points_of_strands(guides, offsets)
    listed = min(_LISTED, len(theirs))
    near = KDTree(points[theirs]).query(points[mine], listed, workers=get_num_threads())[1].reshape(len(mine), listed)
    owners = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    out = no_places(len(mine))
    _choose(near, theirs, owners, out.points)
    _look_back(points, offsets, turns, owners, mine, out)
    return out


def renewed(
    before: tuple[np.ndarray, Places],
    carried: np.ndarray,
    points: np.ndarray,
    offsets: np.ndarray,
    turns: np.ndarray,
) -> Places:
    """Return the new places of followers: unchanged where all their guides remain guides, else the nearest; pure.

    before   previous followers, ascending, (n,), with their places
    carried  strands that are interpolated from now on, (S,) bool: the others may be followed
    points, offsets, turns  as for `find_places`
    """
    strands, places = before
    mine = points_of_strands(np.flatnonzero(carried), offsets)
    followed = carried[np.repeat(np.arange(len(carried)), np.diff(offsets))][places.points] & (places.points >= 0)
    rows = np.full(len(points), -1)
    rows[points_of_strands(strands, offsets)] = np.where(followed.any(axis=1), -1, np.arange(len(followed)))
    rows = rows[mine]
    kept = rows >= 0
    fresh = np.flatnonzero(rows < 0)
    out = no_places(len(mine))
    guides = np.flatnonzero(~carried)
    news = find_places(points, offsets, guides, mine[fresh], turns) if len(fresh) else no_places(0)
    for whole, was, found in zip(out, places, news, strict=True):
        whole[kept], whole[fresh] = was[rows[kept]], found
    return out


def guides_beside(strands: np.ndarray, followed: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the possible guides of strands, ordered by the number of their points that a strand follows; pure.

    strands   ascending, (n,); offsets  offsets of all strands, (S+1,) int32
    followed  guide points that each of their points follows, as in `Places`, (F, FOLLOWED)

    Returns (n, FOLLOWED) int32, -1: no more. A guide has as many segments as its followers.
    """
    beside = np.full((len(strands), FOLLOWED), -1, np.int32)
    counts = np.diff(offsets)
    begins = np.concatenate([[0], np.cumsum(counts[strands])])
    owners = np.repeat(np.arange(len(counts)), counts)
    _rank(followed, owners, counts, strands, begins, beside)
    return beside


@inlined
def turn_at(offsets: np.ndarray, strand: int, point: int) -> int:
    """Return the segment by whose turn a point of a strand turns: that which leads to it, of a root the first."""
    return point if point == offsets[strand] else point - 1


@njit(cache=True, parallel=True)
def _choose(near, theirs, owners, followed):
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


@njit(cache=True, parallel=True)
def _rank(followed, owners, counts, strands, begins, beside):
    """Write the owners of most places of each strand, in place; of as many, the first strand."""
    for f in prange(len(strands)):
        places = followed[begins[f] : begins[f + 1]].reshape(-1)
        guides = np.sort(owners[places[places >= 0]])  # Sorted: each guide is one run, ties go to the lower number.
        times = np.zeros(FOLLOWED, np.int64)
        first = 0
        while first < len(guides):
            guide = guides[first]
            end = first
            while end < len(guides) and guides[end] == guide:
                end += 1
            if counts[guide] == counts[strands[f]]:
                _insert(guide, end - first, beside[f], times)
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
        for j in range(FOLLOWED):
            place = np.int64(places.points[i, j])
            if place >= 0:
                turn = turn_at(offsets, owners[place], place)
                put(places.offsets[:, j], i, turned_back(turns, turn, minus(x, row(points, place))))
        if p > offsets[strand]:
            bend = minus(row(points, p - 1), x)
            if p + 1 < offsets[strand + 1]:
                bend = plus(bend, minus(row(points, p + 1), x))
            nearest = np.int64(places.points[i, 0])  # Turned back by the guide that `_smooth` will turn it with.
            put(places.bends, i, turned_back(turns, turn_at(offsets, owners[nearest], nearest), bend))
