"""Linear spring-dampers between points of two segments, which couple strands in one linear system.

A coupling i joins the point (1 - s) x_k + s x_(k+1) of its first segment k to that of its second. With J_i the matrix
that maps velocities of points to the relative velocity of the two, first minus second, a stage solves

    (A + sum_i J_i^T M_i J_i) dv = b + sum_i J_i^T push_i,   M = t (h K + C),   push = t (f - C v_rel),

A and b being those of the strands without couplings, h the weight of the stage's end, the mean of those of the two
strands, and t the duration of the stage: forces between strands are not part of accelerations, so they act for all of
it. Every term of J^T M J is in exactly one of two operators, so that
P + O is the matrix of the entire system:

    P = A + own    terms between points of one and the same segment. For the axis particle of point k diagonal[k] goes
                   to the block on the diagonal, following[k] to that which couples it to the axis particle of point
                   k + 1: both lie in the band of its strand, and so in its factors.
    O              `multiply_across`: terms between points of the two segments of a coupling, also where both belong
                   to one strand; conjugate gradients multiply by it, `solve/conjugate_gradients.py`.

J^T push is added to the right-hand side of the strands. Rows of held particles (roots) are fixed afterwards. The
couplings at a point are found once, by `find_incidence`, and are valid while `segments` do not change; every point
gathers from its own list, in the order of the couplings, so that no result depends on threads: `coupling_rows` in
`solve/couplings.py`.

Couplings sorted by segment: the operator of the conjugate gradient iterations.

A coupling is stored once for each of its sides, in few bytes, since dense hair has hundreds of megabytes of them:
directions and fractions are rounded to 1 / 32767, equally for both sides, and own blocks are built from the same
numbers, so that P + O (`solve/couplings.py`) remains the positive semidefinite matrix of springs.
"""

from typing import NamedTuple, Protocol

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import AHEAD, fetch, inlined
from hairpipe.geometry.simd_vec4 import WHOLE, dot, item, load_four, load_short_four, without_first, zeros
from hairpipe.geometry.sorting import runs_of, sorted_by_bits
from hairpipe.geometry.sym3 import outer
from hairpipe.geometry.vec3 import plus, scaled

PUSH, DIRECTION, ALONG, ACROSS = 0, 3, 6, 7
"""Place of the impulse of a coupling in its row."""


class Couplings(NamedTuple):
    """A set of couplings.

    segments   a segment joins a point to the next of its strand and has the index of the point, (n, 2) int32
    fractions  positions on the segments, 0 at that point and 1 at the next, (n, 2)
    acts       whether a coupling is active, (n,) bool; if not, `exerted` is not set
    exerted    contiguous, since all values are read together at random places in memory, (n, 8) float32:

    push       impulse on the first point, the opposite on the second [N s], (n, 3)
    direction  d, a unit vector, (n, 3)
    strength   along and across it, a and b of M = a d d^T + b (I - d d^T), not negative [kg], (n, 2)
    """

    segments: np.ndarray
    fractions: np.ndarray
    acts: np.ndarray
    exerted: np.ndarray

    @property
    def push(self) -> np.ndarray:
        """The first three numbers; memory is shared."""
        return self.exerted[:, PUSH : PUSH + 3]

    @property
    def direction(self) -> np.ndarray:
        """The next three; memory is shared."""
        return self.exerted[:, DIRECTION : DIRECTION + 3]

    @property
    def strength(self) -> np.ndarray:
        """The last two; memory is shared."""
        return self.exerted[:, ALONG:]


class Incidence(NamedTuple):
    """The couplings at each segment.

    first  couplings of segment k are sides[first[k]:first[k+1]], (points+1,) int32
    sides  2 i + j: coupling i, of which the segment is the first (j = 0) or the second (j = 1), ascending, (2 n,) int32
    """

    first: np.ndarray
    sides: np.ndarray


class Places(Protocol):
    """Places of couplings, see `Couplings`."""

    @property
    def segments(self) -> np.ndarray:
        """Pairs of segments, (n, 2) int32."""
        ...

    @property
    def fractions(self) -> np.ndarray:
        """Where on them, (n, 2)."""
        ...


class Joined(NamedTuple):
    """Places one set after the other: see `Couplings`."""

    segments: np.ndarray
    fractions: np.ndarray


NOWHERE = Joined(np.empty((0, 2), np.int32), np.empty((0, 2)))
"""No pairs."""


def join(*places: Places) -> Joined:
    """Concatenate sets of places."""
    segments = np.concatenate([some.segments for some in places])
    return Joined(segments, np.concatenate([some.fractions for some in places]))


def couplings_at(places: Places) -> Couplings:
    """Make couplings with room for what they exert."""
    count = len(places.segments)
    return Couplings(places.segments, places.fractions, np.zeros(count, np.bool_), np.empty((count, 8), np.float32))


def part_of(couplings: Couplings, begin: int, end: int) -> Couplings:
    """Return couplings begin to end; memory is shared."""
    return Couplings(*(array[begin:end] for array in couplings))


def matrices(couplings: Couplings) -> np.ndarray:
    """Return M of all couplings that act, and zeros of the others [kg], (n, 3, 3) float64; pure."""
    d = couplings.direction.astype(np.float64)
    along, across = couplings.strength.astype(np.float64).T[:, :, None, None]
    M = across * np.eye(3) + (along - across) * d[:, :, None] * d[:, None, :]
    return np.where(couplings.acts[:, None, None], M, 0.0)


def find_incidence(segments: np.ndarray, points: int) -> Incidence:
    """Find the couplings of every segment, of so many points; segments  (n, 2) int32; pure."""
    keys = np.empty(2 * len(segments), np.int64)
    sides = np.empty(len(keys), np.int32)
    _find_keys(segments, keys)
    # Equal keys keep the order of the couplings: each point sums up its list in that order.
    keys = sorted_by_bits(keys, 32, 32 + int(points).bit_length())
    _find_sides(keys, sides)
    return Incidence(runs_of(keys, points), sides)


@njit(cache=True, parallel=True)
def _find_keys(segments, keys):
    """Write the segment of every side of a coupling, and the side."""
    for i in prange(len(segments)):
        for j in range(2):
            side = 2 * np.int64(i) + j
            keys[side] = np.int64(segments[i, j]) << 32 | side


@njit(cache=True, parallel=True)
def _find_sides(keys, sides):
    for k in prange(len(keys)):
        sides[k] = keys[k] & 0xFFFFFFFF


_CHUNK = 2048
"""Points that are gathered one after the other."""
_NO_BLOCK = (0.0,) * 6
_NO_PUSH = (0.0, 0.0, 0.0)


class CouplingRows(NamedTuple):
    """Active couplings sorted by segment, and their blocks within the points of each segment.

    first      couplings of segment k are first[k] : first[k+1], (points+1,) int32
    others     segment on the other side, (2 n,) int32
    places     x y z of the direction and the fraction on the other side, in units of 1 / `WHOLE`, (2 n, 4) int16
    numbers    strength across the direction, additional strength along it [kg], fraction on this side, (2 n, 3) float32
    push       J^T push [N s], (points, 3) float64
    diagonal   own block between a point and itself, symmetric [kg], (points, 6) float32
    following  block between a point and the next of its strand, symmetric [kg], (points, 6) float32
    """

    first: np.ndarray
    others: np.ndarray
    places: np.ndarray
    numbers: np.ndarray
    push: np.ndarray
    diagonal: np.ndarray
    following: np.ndarray


def coupling_rows(couplings: Couplings, incidence: Incidence) -> CouplingRows:
    """Sort couplings that act by the segments that they touch, and sum up what points have of them; pure."""
    first = np.zeros_like(incidence.first)
    _count_acting(couplings.acts, incidence, first)
    count = first[-1]
    points = len(first) - 1
    # Memory from numpy, in huge pages: all of it is read in every iteration.
    others = np.empty(count, np.int32)
    places = np.empty((count, 4), np.int16)
    own = (np.empty((points, size), dtype) for size, dtype in ((3, np.float64), (6, np.float32), (6, np.float32)))
    out = CouplingRows(first, others, places, np.empty((count, 3), np.float32), *own)
    _gather(couplings, incidence, out)
    return out


@njit(cache=True, parallel=True)
def _count_acting(acts, incidence, first):
    for chunk in prange(-(-(len(first) - 1) // _CHUNK)):
        for k in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(first) - 1)):
            for e in range(incidence.first[k], incidence.first[k + 1]):
                first[k + 1] += acts[incidence.sides[e] >> 1]  # Left out once here, not in every iteration.
    for k in range(1, len(first)):
        first[k] += first[k - 1]


@njit(cache=True, parallel=True)
def _gather(couplings, incidence, out):
    for chunk in prange(-(-len(out.push) // _CHUNK)):
        _gather_some(couplings, incidence, out, np.int64(chunk) * _CHUNK)


@njit(cache=True)
def _gather_some(couplings, incidence, out, begin):
    """Traverse the segments of a chunk: each adds to its own point, and passes the term of the next point on."""
    first, sides, acts, exerted = incidence.first, incidence.sides, couplings.acts, couplings.exerted
    fractions = couplings.fractions
    transferred, transferred_push = _NO_BLOCK, _NO_PUSH
    for k in range(max(begin - 1, 0), min(begin + _CHUNK, len(out.push))):
        near, far, between, near_push, far_push = _NO_BLOCK, _NO_BLOCK, _NO_BLOCK, _NO_PUSH, _NO_PUSH
        place = out.first[k]
        for e in range(first[k], first[k + 1]):
            # The couplings of a segment lie anywhere in memory: they are fetched before they are needed.
            ahead = sides[min(e + AHEAD, len(sides) - 1)] >> 1
            if acts[ahead]:
                fetch(exerted, ahead)
                fetch(fractions, ahead)
                fetch(couplings.segments, ahead)
            i = sides[e] >> 1
            j = sides[e] & 1
            if acts[i]:
                M, r = _enter(couplings, i, j, out, place)
                near = _more_block(near, (1.0 - r) * (1.0 - r), M)
                far = _more_block(far, r * r, M)
                between = _more_block(between, r * (1.0 - r), M)
                sign = 1.0 - 2.0 * j  # The push acts on the first segment, and the opposite on the second.
                s = fractions[i, j]
                push = (exerted[i, PUSH], exerted[i, PUSH + 1], exerted[i, PUSH + 2])
                near_push = plus(near_push, scaled(sign * (1.0 - s), push))
                far_push = plus(far_push, scaled(sign * s, push))
                place += 1
        if k >= begin:  # Row begin - 1 belongs to another thread: it only gives what it passes on to the next.
            for c in range(6):
                out.diagonal[k, c], out.following[k, c] = near[c] + transferred[c], between[c]
            for c in range(3):
                out.push[k, c] = near_push[c] + transferred_push[c]
        transferred, transferred_push = far, far_push


@inlined
def _enter(couplings, i, j, rows, place):
    """Write down coupling i as its segment j sees it; return its matrix, xx to zz, and where it is, as written down."""
    rows.others[place] = couplings.segments[i, 1 - j]
    # Towards zero: a direction that is longer than 1 would make a matrix that is not positive.
    for c in range(3):
        rows.places[place, c] = np.int16(WHOLE * couplings.exerted[i, DIRECTION + c])
    rows.places[place, 3] = _rounded(couplings.fractions[i, 1 - j])
    rows.numbers[place, 0] = couplings.exerted[i, ACROSS]
    rows.numbers[place, 1] = couplings.exerted[i, ALONG] - couplings.exerted[i, ACROSS]
    rows.numbers[place, 2] = _rounded(couplings.fractions[i, j]) / WHOLE
    # Own blocks are made of the rounded numbers, so that P + O is the matrix of one set of springs.
    across, more = np.float64(rows.numbers[place, 0]), np.float64(rows.numbers[place, 1])
    x, y, z = rows.places[place, 0] / WHOLE, rows.places[place, 1] / WHOLE, rows.places[place, 2] / WHOLE
    xx, xy, xz, yy, yz, zz = outer(more, (x, y, z))
    return (across + xx, xy, xz, across + yy, yz, across + zz), np.float64(rows.numbers[place, 2])


@inlined
def _more_block(sums, weight, M):
    return (
        sums[0] + weight * M[0],
        sums[1] + weight * M[1],
        sums[2] + weight * M[2],
        sums[3] + weight * M[3],
        sums[4] + weight * M[4],
        sums[5] + weight * M[5],
    )


@inlined
def _rounded(fraction):
    return np.int16(WHOLE * fraction + 0.5)


@inlined
def _acts(matrix, i):
    """Whether a matrix, positive semidefinite, is not zero."""
    return matrix[i, 0] + matrix[i, 3] + matrix[i, 5] > 0.0


@njit(cache=True, parallel=True)
def multiply_across(rows: CouplingRows, v: np.ndarray, start: np.ndarray, out: np.ndarray) -> None:
    """Set out to start + O v, O being the terms between points of different sides of a coupling, in place.

    v           [m/s], (points, 3) float32
    start, out  [N s], (points, 3) float32
    """
    places = rows.places.reshape(-1)
    speeds = v.reshape(-1)
    for chunk in prange(-(-len(out) // _CHUNK)):
        _multiply_some(rows, places, speeds, start, out, np.int64(chunk) * _CHUNK)


@njit(cache=True, parallel=True)
def rounded_speeds(v):
    """Copy vectors, (points, 3), one behind the other in single precision, (3 points,)."""
    out = np.empty(3 * len(v), np.float32)
    for chunk in prange(-(-len(v) // _CHUNK)):
        for k in range(np.int64(chunk) * _CHUNK, min((np.int64(chunk) + 1) * _CHUNK, len(v))):
            for c in range(3):
                out[3 * k + c] = v[k, c]
    return out


@njit(cache=True, parallel=True)
def impulses_after(rows: CouplingRows, change: np.ndarray, active: np.ndarray, out: np.ndarray) -> None:
    """Set out to impulses after a change of velocities, J^T (push - M J dv), for active points, in place.

    change  dv [m/s], (points, 3)
    active     points to compute, (points,) bool
    out     [N s], (points, 3)
    """
    places = rows.places.reshape(-1)
    rounded = rounded_speeds(change)
    for chunk in prange(-(-len(out) // _CHUNK)):
        begin = np.int64(chunk) * _CHUNK
        for k in range(begin, min(begin + _CHUNK, len(out))):
            if active[k]:
                total, far = _across(rows, places, k, rounded)
                near = total - far
                if k > 0:  # Summed up anew from the segment before: active points need not be contiguous.
                    near = near + _across(rows, places, k - 1, rounded)[1]
                own = _own_part(rows, change, k)
                for c in range(3):
                    out[k, c] = rows.push[k, c] - own[c] + item(near, c)


@njit(cache=True, parallel=True)
def follow(rows: CouplingRows, change: np.ndarray, active: np.ndarray, total: np.ndarray, out: np.ndarray) -> None:
    """Update for changed velocities of active points, in place; arguments as for `impulses_after`.

    total  sum of all changes, to which this one is added; non-finite changes count as 0 [m/s], (points, 3)
    out    impulses, reduced by the effect of the own strand's change [N s], (points, 3)
    """
    for chunk in prange(-(-len(out) // _CHUNK)):
        for k in range(np.int64(chunk) * _CHUNK, min((np.int64(chunk) + 1) * _CHUNK, len(out))):
            if active[k]:
                own = _own_part(rows, change, k)
                for c in range(3):
                    out[k, c] -= own[c]
                    if abs(change[k, c]) < np.inf:  # A lost strand must not move the others (false for NaN).
                        total[k, c] += change[k, c]


@inlined
def _own_part(rows, v, k):
    """Product of own blocks and the velocities at point k [N s]."""
    diagonal, following = rows.diagonal, rows.following
    y = _times(diagonal, k, v, k)
    # Where nothing acts, the next point may be another strand's, and lost.
    if _acts(following, k):
        y = plus(y, _times(following, k, v, k + 1))
    if k > 0 and _acts(following, k - 1):
        y = plus(y, _times(following, k - 1, v, k - 1))
    return y


@inlined
def _times(M, m, v, k):
    a, b, c = v[k, 0], v[k, 1], v[k, 2]
    return (
        M[m, 0] * a + M[m, 1] * b + M[m, 2] * c,
        M[m, 1] * a + M[m, 3] * b + M[m, 4] * c,
        M[m, 2] * a + M[m, 4] * b + M[m, 5] * c,
    )


@inlined
def _across(rows, places, k, v):
    """Product of the other sides for segment k in all, and for its next point: -O v [N s]."""
    first, others, numbers = rows.first, rows.others, rows.numbers
    total, far = zeros(), zeros()
    for e in range(first[k], first[k + 1]):
        ahead = np.int64(others[min(e + AHEAD, len(others) - 1)])
        fetch(v, 3 * ahead)  # The other side lies anywhere in memory, and its six numbers may span two cache lines.
        fetch(v, 3 * ahead + 5)
        d = load_short_four(places, 4 * e)
        q = np.int64(others[e])
        before = load_four(v, 3 * q)
        # Four numbers are read from one before: a read of four at 3 q + 3 would pass the end of the array.
        after = without_first(load_four(v, 3 * q + 2))
        u = before + item(d, 3) * (after - before)
        y = numbers[e, 0] * u + (numbers[e, 1] * dot(d, u)) * d
        total = total + y
        far = far + numbers[e, 2] * y
    return total, far


@njit(cache=True)
def _multiply_some(rows, places, v, start, out, begin):
    """Walk as `_gather_some` does."""
    # The segment before the chunk is computed twice, so that no thread waits for another.
    transferred = _across(rows, places, begin - 1, v)[1] if begin > 0 else zeros()
    for k in range(begin, min(begin + _CHUNK, len(out))):
        total, far = _across(rows, places, k, v)
        near = total - far + transferred
        for c in range(3):
            out[k, c] = start[k, c] - item(near, c)
        transferred = far
