"""Linear spring-dampers between points of two segments: what couples strands, in one linear system with them.

A coupling i joins the point (1 - s) x_k + s x_(k+1) of its first segment k to that of its second. With J_i the matrix
that takes velocities of points to the relative velocity of the two, first minus second, a stage solves

    (A + sum_i J_i^T M_i J_i) dv = b + sum_i J_i^T push_i,   M = t (h K + C),   push = t (f - C v_rel),

A and b being those of the strands without couplings, h the weight of the stage's end, the mean of those of the two
strands, and t the time that the stage covers: what strands do to each other is no part of accelerations, so it acts all
that time. Every term of J^T M J is in exactly one of two places, so that
P + O is the matrix of the whole system:

    P = A + own    `own_blocks`: terms between points of one and the same segment. For the axis particle of point k its
                   diagonal[k] goes to the block on the diagonal, next[k] to that which couples it to the axis particle
                   of point k + 1: both lie in the band of its strand, and so in its factors.
    O              `multiply_across`: terms between points of the two segments of a coupling, also where both belong
                   to one strand; conjugate gradients multiply by it, `sim/contact/conjugate.py`.

The right-hand side of the strands gets `add_push`. Rows of held particles (roots) are fixed after all of that. Which
couplings touch a point is found once, by `find_incidence`, and holds as long as `segments` stay what they are; every
point gathers from its own list, in the order of the couplings, so that no result depends on threads. `own_blocks` and
`multiply_across` have them in that order, `sim/contact/sides.py`.
"""

from typing import NamedTuple, Protocol

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined
from hairpipe.sim.fetch import AHEAD, fetch

_CHUNK = 2048
"""Points that are gathered one after the other."""


class Couplings(NamedTuple):
    """A set of couplings.

    segments   a segment joins a point to the next of its strand and has its number, (n, 2) int32
    fractions  where on the segments, 0 at that point and 1 at the next, (n, 2)
    acts       whether a coupling exerts anything, (n,) bool; where not, all below is not set
    push       impulse on the first point, the opposite on the second [N s], (n, 3) float32
    direction  d, a unit vector, (n, 3) float32
    strength   along and across it, a and b of M = a d d^T + b (I - d d^T), not negative [kg], (n, 2) float32
    """

    segments: np.ndarray
    fractions: np.ndarray
    acts: np.ndarray
    push: np.ndarray
    direction: np.ndarray
    strength: np.ndarray


class Incidence(NamedTuple):
    """Which couplings touch a segment.

    first  those of segment k are sides[first[k]:first[k+1]], (points+1,) int32
    sides  2 i + j: coupling i, of which the segment is the first (j = 0) or the second (j = 1), ascending, (2 n,) int32
    """

    first: np.ndarray
    sides: np.ndarray


class Places(Protocol):
    """Where things couple: see `Couplings`."""

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


def join(*places: Places) -> Joined:
    """Put places one set after the other."""
    segments = np.concatenate([some.segments for some in places])
    return Joined(segments, np.concatenate([some.fractions for some in places]))


def couplings_at(places: Places) -> Couplings:
    """Make couplings with room for what they exert."""
    count = len(places.segments)
    exerted = (np.empty((count, size), np.float32) for size in (3, 3, 2))
    return Couplings(places.segments, places.fractions, np.zeros(count, np.bool_), *exerted)


def part_of(couplings: Couplings, begin: int, end: int) -> Couplings:
    """Return couplings begin to end; memory is shared."""
    return Couplings(*(array[begin:end] for array in couplings))


def matrices(couplings: Couplings) -> np.ndarray:
    """Return M of all couplings that act, and zeros of the others [kg], (n, 3, 3) float64; pure."""
    d = couplings.direction.astype(np.float64)
    along, across = couplings.strength.astype(np.float64).T[:, :, None, None]
    M = across * np.eye(3) + (along - across) * d[:, :, None] * d[:, None, :]
    return np.where(couplings.acts[:, None, None], M, 0.0)


@njit(cache=True)
def find_incidence(segments: np.ndarray, points: int) -> Incidence:
    """Find which couplings touch every segment, by counting.

    segments  (n, 2) int32; points  their number
    """
    first = np.zeros(points + 1, np.int32)
    for i in range(len(segments)):
        for j in range(2):
            first[segments[i, j] + 1] += 1
    for k in range(points):
        first[k + 1] += first[k]
    free = first[:-1].copy()
    sides = np.empty(2 * len(segments), np.int32)
    for i in range(len(segments)):
        for j in range(2):
            k = segments[i, j]
            sides[free[k]] = 2 * i + j
            free[k] += 1
    return Incidence(first, sides)


@njit(cache=True, parallel=True)
def add_push(couplings: Couplings, incidence: Incidence, out: np.ndarray) -> None:
    """Add J^T push to every point [N s], (points, 3), in place."""
    for chunk in prange(-(-len(out) // _CHUNK)):
        _push_some(couplings, incidence, out, np.int64(chunk) * _CHUNK)


@njit(cache=True)
def _push_some(couplings, incidence, out, begin):  # noqa: ANN001, ANN202
    """Walk along the segments of a chunk: each gives the part of its own point, and carries that of the next."""
    first, sides, push, fractions = incidence.first, incidence.sides, couplings.push, couplings.fractions
    acts = couplings.acts
    carried = (0.0, 0.0, 0.0)
    for k in range(max(begin - 1, 0), min(begin + _CHUNK, len(out))):
        near, far = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for e in range(first[k], first[k + 1]):
            i, j = sides[e] >> 1, sides[e] & 1
            ahead = sides[min(e + AHEAD, len(sides) - 1)] >> 1
            if acts[ahead]:
                fetch(push, ahead)
                fetch(fractions, ahead)
            if acts[i]:
                sign, s = 1.0 - 2.0 * j, fractions[i, j]
                near = _grow(near, sign * (1.0 - s), push[i])
                far = _grow(far, sign * s, push[i])
        if k >= begin:
            for c in range(3):
                out[k, c] += near[c] + carried[c]
        carried = far


@inlined
def _grow(sums, weight, y):  # noqa: ANN001, ANN202
    return sums[0] + weight * y[0], sums[1] + weight * y[1], sums[2] + weight * y[2]
