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
`solve/coupling_operator.py`.
"""

from typing import NamedTuple, Protocol

import numpy as np
from numba import njit, prange

from hairpipe.geometry.sorting import runs_of, sorted_by_bits

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
