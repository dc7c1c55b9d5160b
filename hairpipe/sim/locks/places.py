"""Places of a follower among the guides: the guide points nearest to each of its points, and the offsets from them.

Hairs of a lock cross and slide along each other, so the neighbours of a hair change along it. Each of its points
follows the few nearest guide points, of any lock, when it begins to follow; if one of these guides becomes a follower,
the point restarts, not the whole hair. Compared with a hair that follows only its own guide, this halves the error
(`measure_locks`).
"""

import numpy as np
from numba import get_num_threads, njit, prange
from scipy.spatial import KDTree

from hairpipe.data.locks import FOLLOWED, Places, no_places
from hairpipe.groom.keys.key_turns import turned_back
from hairpipe.groom.resampling import put
from hairpipe.groom.strand_arrays import points_of_strands
from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import minus, plus, row

_LISTED = 24
"""Nearest places among which they are chosen: several are on one guide."""


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
