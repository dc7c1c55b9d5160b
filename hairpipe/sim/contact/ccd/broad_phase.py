"""Broad phase: pairs of segments that may come near each other within a step, valid also while its end is corrected.

All pairs that come within reach are listed once. The list is complete as long as no end of a point moves by more than
half the reach. The pairs of points that move farther are listed again, or those of all hair if that is cheaper.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compaction import places_of
from hairpipe.spatial.pair_search import search
from hairpipe.spatial.pairs import known_pairs, picked
from hairpipe.spatial.segment_tree import Frame, Tree, build_tree, find_frame
from hairpipe.spatial.segments import all_segments, refuse_lost

_MANY = 0.125
"""Part of all points; the pairs of more segments than that are listed with all others, which lasts longer."""


class Neighbourhood(NamedTuple):
    """Hair in a step, ready to be searched.

    tree    tree of all segments
    frame   its frame of reference
    reach   search distance [m]
    points  number of points
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

    Raises LostPoints if a position is not finite.
    """
    refuse_lost(before)
    refuse_lost(after)
    segments = all_segments(offsets)
    frame = find_frame(before, after, segments)
    return Neighbourhood(build_tree(before, after, segments, reach, frame), frame, reach, len(before))


def swept_pairs(around: Neighbourhood, ignored: np.ndarray | None = None) -> np.ndarray:
    """List all pairs of segments that come within reach in a motion, and some others, (n, 2) int32; pure.

    ignored  sorted keys of pairs to leave out, see `key_of`, (k,) int64

    The order is arbitrary but reproducible, without duplicates; first < second; the two share no point. The distance
    of two segments falls below that at half time, d, by at most half the largest relative displacement D of their
    ends: the list contains pairs with d <= reach + D / 2 without a separating plane across an axis or across the
    shortest connection at half time.
    """
    return search(around.tree, around.tree, known_pairs(ignored, around.points))


def swept_pairs_of(
    around: Neighbourhood,
    segments: np.ndarray,
    before: np.ndarray,
    after: np.ndarray,
    ignored: np.ndarray | None = None,
) -> np.ndarray:
    """List the pairs of some segments, (m,) int32, whose motion has changed; pure.

    around  hair in its previous motion; before, after  its present motion [m], (P, 3) float64

    These segments move as now, also in pairs of two of them; the others as before. Otherwise as `swept_pairs`.
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


@dataclass(eq=False)
class Candidates:
    """Pairs of segments that may cross in a step.

    before, after  positions [m], (P, 3) float64
    offsets        offsets of the strands, (strands+1,) int32
    reach          search distance [m]; a larger one lists more pairs, less often
    ignored        sorted keys of pairs allowed to cross; or None
    pairs          pairs that may cross in the motion at which all were last listed, and some others, (n, 2) int32
    """

    before: np.ndarray
    after: np.ndarray
    offsets: np.ndarray
    reach: float
    ignored: np.ndarray | None
    pairs: np.ndarray = field(init=False)
    _around: Neighbourhood = field(init=False)
    _sorted: np.ndarray = field(init=False)
    _listed: np.ndarray = field(init=False)
    _again: np.ndarray = field(init=False)
    _fresh: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self._list_all(self.after)

    def renew(self, ends: np.ndarray) -> None:
        """Change the end positions of points [m], (P, 3)."""
        if not _apart(ends, self._listed, 0.5 * self.reach).any():
            return
        far = _apart(ends, self._sorted, 0.5 * self.reach)
        touched = touched_by(far, self.offsets)
        segments = places_of(touched).astype(np.int32)
        if len(segments) > _MANY * len(ends):
            self._list_all(ends)
        else:
            # An end that is not far is where it was: else it might go on by half the reach, again and again.
            self._listed = np.empty_like(ends)
            _select(far, ends, self._sorted, self._listed)
            self._again = touched
            self._fresh = swept_pairs_of(self._around, segments, self.before, self._listed, self.ignored)

    def of(self, points: np.ndarray) -> np.ndarray:
        """Return the pairs that may cross in the present motion with one of the marked points, (P,) bool."""
        touched = touched_by(points, self.offsets)
        kept = picked(self.pairs, _among(self.pairs, touched, self._again))
        return np.concatenate([kept, picked(self._fresh, _among(self._fresh, touched, np.zeros_like(touched)))])

    def _list_all(self, ends: np.ndarray) -> None:
        self._around = neighbourhood(self.before, ends, self.offsets, self.reach)
        self.pairs = swept_pairs(self._around, self.ignored)
        self._sorted = self._listed = ends.copy()
        self._again, self._fresh = np.zeros(len(ends), np.bool_), self.pairs[:0]


def touched_by(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Mark the segments, by where they begin, of which an end is marked, (P,) bool; pure."""
    touched = np.zeros_like(points)
    _touch(points, offsets, touched)
    return touched


@njit(cache=True, parallel=True)
def _touch(points, offsets, touched):
    for strand in prange(len(offsets) - 1):
        for k in range(offsets[strand], offsets[strand + 1] - 1):
            touched[k] = points[k] or points[k + 1]


@njit(cache=True, parallel=True)
def _select(marked, x, y, out):
    """Set out, (P, 3), to x where points are marked, and else to y, in place."""
    for k in prange(len(out)):
        for c in range(3):
            out[k, c] = x[k, c] if marked[k] else y[k, c]


@njit(cache=True, parallel=True)
def _apart(x, y, distance):
    """Mark the points that are farther than a distance apart, (P,) bool; those that are lost, too."""
    apart = np.empty(len(x), np.bool_)
    for k in prange(len(x)):
        a, b, c = x[k, 0] - y[k, 0], x[k, 1] - y[k, 1], x[k, 2] - y[k, 2]
        apart[k] = not a * a + b * b + c * c <= distance * distance  # Written with `not`, so that NaN counts as apart.
    return apart


@njit(cache=True, parallel=True)
def _among(pairs, marked, excluded):
    """Mark the pairs, (n, 2), of which one is marked, and none is excluded, (n,) bool."""
    among = np.empty(len(pairs), np.bool_)
    for k in prange(len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        among[k] = (marked[i] or marked[j]) and not (excluded[i] or excluded[j])
    return among
