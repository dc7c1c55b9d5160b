"""Step 6: collisions between hairs in a step, after Bridson et al. 2002, edges against edges.

A crossing at the fractions s, t of two segments, with normal n, has the gap g0 = n.J x0 before the step and n.J x1 =
g0 + dt n.u after it, u = J (x1 - x0) / dt. An impulse at these points changes n.u so that the gap ends at g:

    g = g0, but at most the thickness that is kept, and at least a hundredth of it;   dv = (g - g0) / dt - n.u > 0

with restitution 0 and Coulomb friction. Impulses change x1 and v alike, by dt and by 1 times their effect on u. New
crossings are searched among the pairs that they moved and added to the solve, up to a number of attempts. What still
crosses then moves as one in this step, see `move_as_one`.

We differ from the paper, where an impulse stops the approach of the whole step, as if hair touched at its start: here
hair approaches up to the thickness. And every attempt iterates over the crossings of all previous attempts, longer
than the one before, so that one solution does not undo another. The authors' code makes up to four attempts, and then
lets hair pass, which is tangled for good. Zones of Bridson et al. also turn.

Broad phase: all pairs that may come within reach in the step are listed once. The list is complete as long as no end of
a point moves by more than half the reach. The pairs of points that move farther are listed again, or those of all hair
if that is cheaper.

Crossings, Sec. 5.3: the first time at which two segments that move linearly are coplanar and meet, a root of a cubic.

With A, C the segments and P the vector from the start of the first to that of the second, all linear in the time t of
0..1, f(t) = (A x C) . P = 0, Bridson et al. 2002 Sec. 6. As a product of linear functions it has the Bernstein
coefficients

    b0 = N0.P0,  b1 = (N01.P0 + N0.P1) / 3,  b2 = (N01.P1 + N1.P0) / 3,  b3 = N1.P1,   N01 = A0 x C1 + A1 x C0

without differences of them; if all have one sign there is no root. `may_cross` tests this for eight pairs at once,
which excludes most pairs. Between its extremes f is monotone.

For segments that are coplanar at all times, or nearly parallel, the cubic is degenerate. These meet where an end
reaches the line of the other: with E from the start of a segment A to an end of the other, E x A = 0, a quadratic in
time, solved for its largest component.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.contact.contact_points import apply, between, inverse_mass
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.proximity import search
from hairpipe.geometry.segment_distance import closest_on_segments
from hairpipe.geometry.segment_tree import Frame, Tree, build_tree, find_frame
from hairpipe.geometry.segments import TOUCHING, all_segments, key_of, known_pairs, mean_width, refuse_lost
from hairpipe.geometry.simd import WIDTH, bits, either, load, lowest, maximum, minimum, sqrt
from hairpipe.geometry.sorting import places_of, rows_at
from hairpipe.geometry.vec3 import (
    Vector,
    any_across,
    cross,
    dot,
    flattened,
    length,
    minus,
    mix,
    plus,
    row,
    scaled,
    unit,
)
from hairpipe.laws.coulomb import impulse
from hairpipe.laws.settings import Collisions

NEARLY_PARALLEL = 1e-6
"""Sine of an angle: what lies farther apart anywhere on the two for that is still touching."""
_PARALLEL = 1e-8
"""Sine of the angle below which the normal of the plane of both is rounding."""


class Encounter(NamedTuple):
    """Segments a b and c d [m], at the start and at the end of a step."""

    a: tuple[Vector, Vector]
    b: tuple[Vector, Vector]
    c: tuple[Vector, Vector]
    d: tuple[Vector, Vector]


@inlined
def encounter(before: np.ndarray, after: np.ndarray, i: int, j: int) -> Encounter:
    """Return the motion of segments i and j between positions [m], (P, 3)."""
    return Encounter(
        (row(before, i), row(after, i)),
        (row(before, i + 1), row(after, i + 1)),
        (row(before, j), row(after, j)),
        (row(before, j + 1), row(after, j + 1)),
    )


@inlined
def meet(pair: Encounter, time: float) -> tuple[float, float, float]:
    """Return fractions of both segments where they are closest at a fraction of the step, and the squared distance.

    For nearly parallel segments this is the middle of the overlap.
    """
    a, b = mix(pair.a[0], pair.a[1], time), mix(pair.b[0], pair.b[1], time)
    c, d = mix(pair.c[0], pair.c[1], time), mix(pair.d[0], pair.d[1], time)
    return closest_on_segments(a, b, c, d, NEARLY_PARALLEL)


@inlined
def lengths(pair: Encounter) -> float:
    """Return the sum of both segments' lengths [m], each where it is longer."""
    first = max(length(minus(pair.b[0], pair.a[0])), length(minus(pair.b[1], pair.a[1])))
    second = max(length(minus(pair.d[0], pair.c[0])), length(minus(pair.d[1], pair.c[1])))
    return first + second


@inlined
def touch_inside(pair: Encounter, time: float) -> bool:
    """Whether the segments touch at a fraction of the step, neither with an end."""
    s, t, squared = meet(pair, time)
    return 0.0 < s < 1.0 and 0.0 < t < 1.0 and squared <= (TOUCHING * lengths(pair)) ** 2


@inlined
def crossing_normal(pair: Encounter, time: float, s: float, t: float) -> Vector:
    """Return the unit normal against which the first segment's point approaches the second's.

    s, t  fractions of the segments where they meet, at a fraction of the step

    The common normal; for parallel segments the direction of approach, normal to them. Without an approach it is an
    arbitrary normal of the first.
    """
    A = minus(mix(pair.b[0], pair.b[1], time), mix(pair.a[0], pair.a[1], time))
    C = minus(mix(pair.d[0], pair.d[1], time), mix(pair.c[0], pair.c[1], time))
    first = mix(minus(pair.a[1], pair.a[0]), minus(pair.b[1], pair.b[0]), s)
    second = mix(minus(pair.c[1], pair.c[0]), minus(pair.d[1], pair.d[0]), t)
    approach = minus(second, first)
    normal = cross(A, C)
    if length(normal) <= _PARALLEL * length(A) * length(C):
        along = A if dot(A, A) >= dot(C, C) else C
        normal = flattened(approach, unit(along, (0.0, 0.0, 0.0)))
        if length(normal) <= _PARALLEL * length(approach) or length(normal) == 0.0:
            normal = any_across(along)
    normal = unit(normal, (0.0, 0.0, 1.0))
    return normal if dot(normal, approach) >= 0.0 else scaled(-1.0, normal)


Cubic = tuple[float, float, float, float]
Path = tuple[Vector, Vector]
"""Of a point, from the start of the step to its end [m]."""
ROWS = 18
"""Rows of lanes that `may_cross` computes in."""
_ROUNDING = 32 * 2.0**-52
_LOOSEST = 1e-4
"""Distance over the lengths of both segments at a root that rounding blurs."""
_EXACTLY = 1e-9
"""Distance over the lengths of both segments at which an end is on the other segment."""


@inlined
def coplanar_time(pair: Encounter) -> float:
    """Return the fraction of the step at which two segments first meet, inf if they do not."""
    A0, A1, C0, C1 = _sides(pair)
    P0, P1 = minus(pair.c[0], pair.a[0]), minus(pair.c[1], pair.a[1])
    N0 = cross(A0, C0)
    N1 = cross(A1, C1)
    N01 = plus(cross(A0, C1), cross(A1, C0))
    b = (dot(N0, P0), (dot(N01, P0) + dot(N0, P1)) / 3.0, (dot(N01, P1) + dot(N1, P0)) / 3.0, dot(N1, P1))
    area = max(length(A0), length(A1)) * max(length(C0), length(C1))
    noise = _ROUNDING * area * max(length(P0), length(P1))
    # All Bernstein coefficients of one sign, beyond rounding: no root, as f is within their hull.
    low = min(min(b[0], b[1]), min(b[2], b[3]))
    high = max(max(b[0], b[1]), max(b[2], b[3]))
    if low > noise or high < -noise:
        return np.inf
    time = _first_root(pair, b, noise)
    is_flat = low >= -noise and high <= noise
    if is_flat or max(length(N0), max(length(N1), 0.5 * length(N01))) <= NEARLY_PARALLEL * area:
        time = min(time, first_graze(pair))  # The cubic is noise here: an end has to come to the other line.
    return time


@inlined
def _sides(pair: Encounter) -> tuple[Vector, Vector, Vector, Vector]:
    a, b, c, d = pair
    return minus(b[0], a[0]), minus(b[1], a[1]), minus(d[0], c[0]), minus(d[1], c[1])


@njit(cache=True)
def _first_root(pair: Encounter, b: Cubic, noise: float) -> float:
    """Return the first root at which the segments meet, inf if there is none."""
    low, high = quadratic_roots(b[1] - b[0], b[2] - b[1], b[3] - b[2])
    left = 0.0
    f_left = b[0]
    for right in (low, high, 1.0):  # Between its extremes the cubic is monotone: at most one root in each interval.
        f_right = _value(b, right)
        if abs(f_left) <= noise and touch_inside(pair, left):  # A double root touches zero without a change of sign.
            return left
        if (f_left < 0.0) != (f_right < 0.0):
            root = _bracketed(b, left, right)
            if _pass(pair, root, noise):
                return root
        left, f_left = right, f_right
    return 1.0 if abs(f_left) <= noise and touch_inside(pair, 1.0) else np.inf


@njit(cache=True)
def _value(b: Cubic, t: float) -> float:
    u = 1.0 - t
    return u * u * (u * b[0] + 3.0 * t * b[1]) + t * t * (3.0 * u * b[2] + t * b[3])


@njit(cache=True)
def _slope(b: Cubic, t: float) -> float:
    u = 1.0 - t
    return 3.0 * (u * u * (b[1] - b[0]) + 2.0 * u * t * (b[2] - b[1]) + t * t * (b[3] - b[2]))


@njit(cache=True)
def _bracketed(b: Cubic, low: float, high: float) -> float:
    """Return the root between low and high, where the cubic changes sign: Newton's method, kept in by bisection."""
    negative_left = _value(b, low) < 0.0  # The bracket is kept while Newton's method converges, which may leave it.
    t = 0.5 * (low + high)
    for _ in range(100):
        value = _value(b, t)
        if (value < 0.0) == negative_left:
            low = t
        else:
            high = t
        slope = _slope(b, t)
        following = t - value / slope if slope != 0.0 else np.inf
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if following == t or high - low <= 1e-16:
            break
        t = following
    return t


@njit(cache=True)
def _pass(pair: Encounter, time: float, noise: float) -> bool:
    """Whether the segments pass through each other at a root of odd order.

    A joint that passes exactly through an edge does so with both of its segments or, rounded, with none: an end counts.
    The distance of nearly parallel lines at the root is that of rounding.
    """
    s, t, squared = meet(pair, time)
    size = lengths(pair)
    allowed = _EXACTLY * size
    if 0.0 < s < 1.0 and 0.0 < t < 1.0:
        A0, A1, C0, C1 = _sides(pair)
        area = length(cross(mix(A0, A1, time), mix(C0, C1, time)))
        blur = noise / area if area > 0.0 else np.inf
        allowed = max(TOUCHING * size, min(blur, _LOOSEST * size))
    return squared <= allowed * allowed


@njit(cache=True)
def first_graze(pair: Encounter) -> float:
    """Return the first fraction of the step at which an end is on the other's line and they touch, else inf."""
    a, b, c, d = pair
    first = np.inf
    for end, start, stop in ((a, c, d), (b, c, d), (c, a, b), (d, a, b)):
        for time in _times_on_line(end, start, stop):
            if time < first and touch_inside(pair, time):
                first = time
    return first


@njit(cache=True)
def _times_on_line(end: Path, start: Path, stop: Path) -> tuple[float, float]:
    E0, E1 = minus(end[0], start[0]), minus(end[1], start[1])
    A0, A1 = minus(stop[0], start[0]), minus(stop[1], start[1])
    q0 = cross(E0, A0)
    q1 = plus(cross(E0, A1), cross(E1, A0))
    q2 = cross(E1, A1)
    largest = -1.0
    times = (1.0, 1.0)
    for first, doubled, last in zip(q0, q1, q2):  # noqa: B905, numba has no strict
        size = max(abs(first), abs(0.5 * doubled), abs(last))
        if size > largest:  # The other components may be nothing but rounding.
            largest = size
            times = quadratic_roots(first, 0.5 * doubled, last)
    return times


@inlined
def quadratic_roots(first: float, middle: float, last: float) -> tuple[float, float]:
    """Return the roots of first u^2 + 2 middle u t + last t^2, u = 1 - t, in 0 < t < 1, in order, and 1 for others.

    Without real roots, returns twice the minimum of its absolute value: rounding may have removed a double root.
    """
    square = first - 2.0 * middle + last
    half = middle - first
    # No difference of nearly equal numbers: one root is q / a, and the other c / q.
    q = -(half + np.copysign(np.sqrt(max(half * half - square * first, 0.0)), half))
    x = q / square if square != 0.0 else 1.0
    y = first / q if q != 0.0 else 1.0
    x, y = x if 0.0 < x < 1.0 else 1.0, y if 0.0 < y < 1.0 else 1.0
    return min(x, y), max(x, y)


@inlined
def may_cross(before, after, pairs, start, room):
    """Return which of the pairs from `start` on may have a root, as bits of an int64, eight of them or to the end."""
    count = min(len(pairs) - start, WIDTH)
    for lane in range(WIDTH):
        # Lanes beyond the last pair repeat it; the mask at the end drops them.
        i, j = pairs[start + min(lane, count - 1), 0], pairs[start + min(lane, count - 1), 1]
        for x in range(3):
            room[x, lane] = before[i + 1, x] - before[i, x]
            room[3 + x, lane] = after[i + 1, x] - after[i, x]
            room[6 + x, lane] = before[j + 1, x] - before[j, x]
            room[9 + x, lane] = after[j + 1, x] - after[j, x]
            room[12 + x, lane] = before[j, x] - before[i, x]
            room[15 + x, lane] = after[j, x] - after[i, x]
    A0, A1, C0, C1 = _row(room, 0), _row(room, 3), _row(room, 6), _row(room, 9)
    P0, P1 = _row(room, 12), _row(room, 15)
    N0, N1, X, Y = cross(A0, C0), cross(A1, C1), cross(A0, C1), cross(A1, C0)
    N01 = (X[0] + Y[0], X[1] + Y[1], X[2] + Y[2])
    b0, b3 = dot(N0, P0), dot(N1, P1)
    b1, b2 = (dot(N01, P0) + dot(N0, P1)) / 3.0, (dot(N01, P1) + dot(N1, P0)) / 3.0
    sizes = maximum(dot(A0, A0), dot(A1, A1)) * maximum(dot(C0, C0), dot(C1, C1))
    noise = _ROUNDING * sqrt(sizes * maximum(dot(P0, P0), dot(P1, P1)))
    low = minimum(minimum(b0, b1), minimum(b2, b3))
    high = maximum(maximum(b0, b1), maximum(b2, b3))
    return ((1 << count) - 1) & ~bits(either(low > noise, high < -noise))


@inlined
def _row(room, r):
    return load(room, (r,)), load(room, (r + 1,)), load(room, (r + 2,))


_CHUNK = 1024


class Crossings(NamedTuple):
    """The first crossing of each pair of crossing segments.

    segments   first < second, rows in lexicographic order, (n, 2) int32
    fractions  positions of the crossing on both segments, (n, 2) float64
    times      time of the crossing, a fraction of the step, (n,) float64
    normals    normal to both, from the second to the first before the crossing, (n, 3) float64
    """

    segments: np.ndarray
    fractions: np.ndarray
    times: np.ndarray
    normals: np.ndarray


def crossings(before: np.ndarray, after: np.ndarray, pairs: np.ndarray) -> Crossings:
    """Find the pairs of segments that pass through or touch each other in a linear motion; pure.

    before, after  positions [m], (P, 3) float64
    pairs          candidates, see `swept_pairs`, (n, 2) int32

    Bridson et al. 2002, edges alone: segments that meet at an end point are left out, unless an edge passes exactly
    through a joint.
    """
    times = np.empty(len(pairs))
    meet = np.empty(len(pairs), np.bool_)
    _find_times(before, after, pairs, times, meet)
    found = places_of(meet)
    found = found[np.argsort(key_of(pairs[found]), kind="stable")]
    times, segments = times[found], pairs[found]
    fractions, normals = np.empty((len(found), 2)), np.empty((len(found), 3))
    _describe(before, after, segments, times, fractions, normals)
    return Crossings(segments, fractions, times, normals)


@njit(cache=True, parallel=True)
def _find_times(before, after, pairs, times, meet):
    """Mark the pairs that meet, and write when, in place."""
    for chunk in prange(-(-len(pairs) // _CHUNK)):
        room = np.empty((ROWS, WIDTH))
        for start in range(np.int64(chunk) * _CHUNK, min((np.int64(chunk) + 1) * _CHUNK, len(pairs)), WIDTH):
            meet[start : start + WIDTH] = False
            # Signs of eight cubics at once; most pairs end here, and the rest are solved one by one.
            possible = may_cross(before, after, pairs, start, room)
            while possible != 0:
                k = start + lowest(possible)
                possible &= possible - 1
                times[k] = coplanar_time(encounter(before, after, pairs[k, 0], pairs[k, 1]))
                meet[k] = times[k] <= 1.0


@njit(cache=True, parallel=True)
def _describe(before, after, segments, times, fractions, normals):
    for k in prange(len(segments)):
        pair = encounter(before, after, segments[k, 0], segments[k, 1])
        fractions[k, 0], fractions[k, 1], _ = meet(pair, times[k])
        normal = crossing_normal(pair, times[k], fractions[k, 0], fractions[k, 1])
        normals[k, 0], normals[k, 1], normals[k, 2] = normal


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
    others = search(mine, around.tree, known)
    return np.concatenate([search(mine, mine, known), others[~np.isin(others, segments).all(axis=1)]])


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
            self._listed = self._sorted.copy()
            self._listed[far] = ends[far]
            self._again = touched
            self._fresh = swept_pairs_of(self._around, segments, self.before, self._listed, self.ignored)

    def of(self, points: np.ndarray) -> np.ndarray:
        """Return the pairs that may cross in the present motion with one of the marked points, (P,) bool."""
        touched = touched_by(points, self.offsets)
        kept = rows_at(self.pairs, places_of(_among(self.pairs, touched, self._again)))
        fresh = rows_at(self._fresh, places_of(_among(self._fresh, touched, np.zeros_like(touched))))
        return np.concatenate([kept, fresh])

    def _list_all(self, ends: np.ndarray) -> None:
        self._around = neighbourhood(self.before, ends, self.offsets, self.reach)
        self.pairs = swept_pairs(self._around, self.ignored)
        self._sorted = self._listed = ends.copy()
        self._again, self._fresh = np.zeros(len(ends), np.bool_), self.pairs[:0]


@njit(cache=True, parallel=True)
def touched_by(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Mark the segments, by where they begin, of which an end is marked, (P,) bool; pure."""
    touched = np.zeros_like(points)
    for strand in prange(len(offsets) - 1):
        for k in range(offsets[strand], offsets[strand + 1] - 1):
            touched[k] = points[k] or points[k + 1]
    return touched


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


_SWEEPS, _ZONES = 8, 100
"""Iterations of the first attempt, and most crossings in zones that move as one, or twice what attempts leave: in
packed hair each zone runs into more hair, and they would grow until all of it is one."""
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

    def crossings_of(change: np.ndarray) -> Crossings:
        _end(after, previous, change, dt, ends, struck)
        candidates.renew(ends)
        return crossings(before, ends, candidates.of(struck))

    for attempt in range(collisions.attempts):
        if not len(met.times):
            break
        together = _in_time(met) if attempt == 0 else _in_time(together, met)
        passages = _passages(before, after, masses, together, thickness, widths, dt)
        _solve(change, passages, masses, together, collisions.friction, _SWEEPS * (attempt + 1))
        met = crossings_of(change)
    stuck = met.segments[:0]
    moved = change
    left = met
    most = max(_ZONES, 2 * len(met.times))
    while len(left.times) and len(stuck) + len(left.times) <= most:
        stuck = np.concatenate([stuck, left.segments])
        moved = change.copy()
        move_as_one(moved, after - before, masses, stuck, dt)
        previous[stuck] = np.nan  # What no zone could move is looked at again, too.
        left = crossings_of(moved)
    if len(left.times) < len(met.times):
        change, met = moved, left
    return Outcome(found, len(met.times), change)


def move_as_one(change: np.ndarray, free: np.ndarray, masses: np.ndarray, pairs: np.ndarray, dt: float) -> None:
    """Let pairs of segments, (n, 2), that share points move as one, by their momentum or as held points, in place.

    free  what points move by without the change [m], (points, 3); the others as for `collide`
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    points, places = np.unique(pairs[:, [0, 0, 1, 1]] + [0, 1, 0, 1], return_inverse=True)
    ends = places.reshape(-1, 4)[:, :3].ravel(), places.reshape(-1, 4)[:, 1:].ravel()
    graph = coo_array((np.ones(len(ends[0])), ends), shape=(len(points), len(points)))
    count, zones = connected_components(graph, directed=False)
    for zone in range(count):
        inside = points[zones == zone]
        held = np.isinf(masses[inside])
        weights = held if held.any() else masses[inside]
        motion = np.average(free[inside] + dt * change[inside], axis=0, weights=weights)
        change[inside] = np.where(held[:, None], 0.0, (motion - free[inside]) / dt)


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
def _solve(change, passages, masses, met, friction, sweeps):
    """Add the effect of impulses to the change of velocity, crossing by crossing, in place."""
    for _ in range(sweeps):
        for i in range(len(passages)):  # The earliest first, on one thread: each sees those before it.
            mass = passages[i, 7]
            if mass == 0.0:
                continue
            n = (passages[i, 0], passages[i, 1], passages[i, 2])
            u = plus((passages[i, 3], passages[i, 4], passages[i, 5]), between(change, met.segments, met.fractions, i))
            dv = passages[i, 6] - dot(n, u)
            if dv > 1e-12 * np.sqrt(dot(u, u)):  # Less is rounding of u, and would mark points as struck that are not.
                apply(change, masses, met.segments, met.fractions, i, impulse(u, n, dv, friction, mass))
