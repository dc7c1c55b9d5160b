"""Step 6: collisions between hairs in a step, after Bridson et al. 2002, edges against edges.

A crossing at the fractions s, t of two segments, with normal n, has the gap g0 = n.J x0 before the step and n.J x1 =
g0 + dt n.u after it, u = J (x1 - x0) / dt. An impulse at these points changes n.u so that the gap ends at g:

    g = g0, but at most the thickness that is kept, and at least a hundredth of it;   dv = (g - g0) / dt - n.u > 0

with restitution 0 and Coulomb friction. Impulses change x1 and v alike, by dt and by 1 times their effect on u. New
crossings are searched among the pairs that they moved and added to the solve, up to a number of attempts; the
remaining crossings are accepted: no rigid zones, as published, since no state of hair is invalid.

We differ from the paper, where an impulse stops the approach of the whole step, as if hair touched at its start: here
hair approaches up to the thickness. And every attempt iterates over the crossings of all previous attempts several
times, so that one solution does not undo another.

Broad phase: pairs of segments that may come near each other within a step, valid also while its end is corrected.

All pairs that come within reach are listed once. The list is complete as long as no end of a point moves by more than
half the reach. The pairs of points that move farther are listed again, or those of all hair if that is cheaper.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.contact.contact_points import apply, between, inverse_mass
from hairpipe.contact.crossings import Crossings, crossings
from hairpipe.geometry.pair_search import search
from hairpipe.geometry.segment_tree import Frame, Tree, build_tree, find_frame
from hairpipe.geometry.segments import all_segments, known_pairs, mean_width, picked, refuse_lost
from hairpipe.geometry.sorting import places_of
from hairpipe.geometry.vec3 import dot, minus, plus, scaled
from hairpipe.laws.coulomb import impulse
from hairpipe.laws.settings import Collisions

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
    """Sort all segments for searches in a linear motion; pure."""
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
    """List the pairs of some segments, (m,) int32, whose motion has changed; pure."""
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


_SWEEPS = 8
_LEAST = 0.01
_LOOK = 0.5
"""Search distance of candidates, in thicknesses: to search again for the few that impulses move by more than half of
that is cheaper than to list a wider neighbourhood of all."""


class Outcome(NamedTuple):
    """Result of the crossings of a step.

    found   pairs of segments that would have crossed; left: pairs that still cross
    change  change of the velocities of points [m/s], whose ends move by it times the step, (points, 3)
    """

    found: int
    left: int
    change: np.ndarray


def collide(
    before: np.ndarray,
    after: np.ndarray,
    masses: np.ndarray,
    offsets: np.ndarray,
    dt: float,
    collisions: Collisions,
    ignored: np.ndarray | None = None,
    widths: np.ndarray | None = None,
) -> Outcome:
    """Find the changes that prevent hair from crossing hair in a step; pure.

    before, after  positions [m], (points, 3)
    masses         masses of the points, inf if held [kg], (points,)
    offsets        offsets of the strands, (strands+1,) int32
    dt             step [s]
    ignored        sorted keys of pairs allowed to cross
    widths         of segments in thicknesses of the settings, (points,); None: 1
    """
    thickness = collisions.thickness.value
    widths = np.ones(len(before)) if widths is None else widths
    candidates = Candidates(before, after, offsets, _LOOK * thickness, ignored)
    met = crossings(before, after, candidates.pairs)
    found = len(met.times)
    together = met
    change, previous = np.zeros(after.shape), np.zeros(after.shape)
    ends = np.empty_like(after)
    struck = np.empty(len(after), np.bool_)
    for attempt in range(collisions.attempts):
        if not len(met.times):
            break
        together = _in_time(met) if attempt == 0 else _in_time(together, met)
        passages = _passages(before, after, masses, together, thickness, widths, dt)
        _solve(change, passages, masses, together.segments, together.fractions, collisions.friction)
        _end(after, previous, change, dt, ends, struck)
        candidates.renew(ends)
        met = crossings(before, ends, candidates.of(struck))
    return Outcome(found, len(met.times), change)


def _in_time(*known: Crossings) -> Crossings:
    """Concatenate crossings, the earliest in the step first."""
    together = Crossings(*(np.concatenate(parts) for parts in zip(*known, strict=True)))
    order = np.argsort(together.times, kind="stable")
    return Crossings(*(part[order] for part in together))


@njit(cache=True, parallel=True)
def _end(after, previous, change, dt, ends, struck):
    """Find where points end, (P, 3), mark those whose change of velocity was another before, (P,) bool, and note it."""
    for k in prange(len(after)):
        struck[k] = False
        for c in range(3):
            ends[k, c] = after[k, c] + dt * change[k, c]
            struck[k] |= change[k, c] != previous[k, c]  # Exactly: only pairs with a changed point are searched again.
            previous[k, c] = change[k, c]


@njit(cache=True, parallel=True, error_model="numpy")
def _passages(before, after, masses, met, thickness, widths, dt):
    """Return every crossing without impulses: n, u [m/s], target n.u [m/s], mass of the pair [kg] or 0, (n, 8)."""
    segments, fractions, normals = met.segments, met.fractions, met.normals
    passages = np.empty((len(segments), 8))
    for i in prange(len(segments)):
        w = inverse_mass(masses, segments, fractions, i)
        n = (normals[i, 0], normals[i, 1], normals[i, 2])
        begun, ended = between(before, segments, fractions, i), between(after, segments, fractions, i)
        gap = dot(n, begun)
        u = scaled(1.0 / dt, minus(ended, begun))
        kept = thickness * mean_width(widths, segments, i)
        end = min(max(gap, _LEAST * kept), kept)
        for c in range(3):
            passages[i, c], passages[i, 3 + c] = n[c], u[c]
        passages[i, 6] = (end - gap) / dt
        passages[i, 7] = 1.0 / w if w > 0.0 else 0.0
    return passages


@njit(cache=True, error_model="numpy")
def _solve(change, passages, masses, segments, fractions, friction):
    """Add the effect of impulses to the change of velocity, crossing by crossing, in place."""
    for _ in range(_SWEEPS):
        for i in range(len(segments)):  # The earliest first, on one thread: each sees those before it.
            mass = passages[i, 7]
            if mass == 0.0:
                continue
            n = (passages[i, 0], passages[i, 1], passages[i, 2])
            u = plus((passages[i, 3], passages[i, 4], passages[i, 5]), between(change, segments, fractions, i))
            dv = passages[i, 6] - dot(n, u)
            if dv > 1e-12 * np.sqrt(dot(u, u)):  # Less is rounding of u, and would mark points as struck that are not.
                apply(change, masses, segments, fractions, i, impulse(u, n, dv, friction, mass))
