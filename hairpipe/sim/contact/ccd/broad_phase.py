"""Pairs of segments that may come near each other within a step."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.spatial.pair_search import search
from hairpipe.spatial.pairs import known_pairs, picked
from hairpipe.spatial.segment_tree import Frame, Tree, build_tree, find_frame
from hairpipe.spatial.segments import all_segments, refuse_lost


class Neighbourhood(NamedTuple):
    """Hair in a step, ready to be searched.

    tree    of all segments
    frame   that it is in
    reach   that it is searched for [m]
    points  number of them
    """

    tree: Tree
    frame: Frame
    reach: float
    points: int


def neighbourhood(before: np.ndarray, after: np.ndarray, offsets: np.ndarray, reach: float) -> Neighbourhood:
    """Sort all segments for searches in a linear motion; pure.

    before, after  positions [m], (P, 3) float64
    offsets        strand s owns points offsets[s] : offsets[s + 1], (S + 1,) int32
    reach          [m]

    Raises LostPoints where a position is not finite.
    """
    refuse_lost(before)
    refuse_lost(after)
    segments = all_segments(len(before), offsets)
    frame = find_frame(before, after, segments)
    return Neighbourhood(build_tree(before, after, segments, reach, frame), frame, reach, len(before))


def swept_pairs(around: Neighbourhood, ignored: np.ndarray | None = None) -> np.ndarray:
    """List all pairs of segments that get within reach in a motion, and some others, (n, 2) int32; pure.

    ignored  sorted keys of pairs to leave out, see `key_of`, (k,) int64

    In no particular order, but each once and always in the same; first < second; the two share no point. Two segments
    get nearer than at half time, d, by no more than half the largest relative displacement D of their ends: kept are
    pairs with d <= reach + D / 2 that no plane keeps apart, across an axis or across the shortest way at half time.
    """
    return search(around.tree, around.tree, known_pairs(ignored, around.points))


def swept_pairs_of(
    around: Neighbourhood,
    segments: np.ndarray,
    before: np.ndarray,
    after: np.ndarray,
    ignored: np.ndarray | None = None,
) -> np.ndarray:
    """List the pairs with one of some segments, (m,) int32, that move otherwise than they did; pure.

    around  hair as it moved; before, after  as it moves now [m], (P, 3) float64

    Of two of these segments both as they move now; the others as they moved. Otherwise as `swept_pairs`.
    """
    known = known_pairs(ignored, around.points)
    mine = build_tree(before, after, segments, around.reach, around.frame)
    is_mine = np.zeros(around.points, np.bool_)
    is_mine[segments] = True
    others = search(mine, around.tree, known)
    return np.concatenate([search(mine, mine, known), picked(others, _lack(others, is_mine))])


@njit(cache=True, parallel=True)
def _lack(pairs, marked):
    """Mark the pairs, (n, 2), of which one is not marked, (n,) bool."""
    lack = np.empty(len(pairs), np.bool_)
    for k in prange(len(pairs)):
        lack[k] = not (marked[pairs[k, 0]] and marked[pairs[k, 1]])
    return lack
