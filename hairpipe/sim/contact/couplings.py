"""Linear spring-dampers between points of two segments: what couples strands, in one linear system with them.

A coupling i joins the point (1 - s) x_k + s x_(k+1) of its first segment k to that of its second. With J_i the matrix
that takes velocities of points to the relative velocity of the two, first minus second, a stage solves

    (A + sum_i J_i^T M_i J_i) dv = b + sum_i J_i^T push_i,   M = h^2 K + h C,   push = h (f - C v_rel),

A and b being those of the strands without couplings. Every term of J^T M J is in exactly one of two places, so that
P + O is the matrix of the whole system:

    P = A + own    `own_blocks`: terms between points of one and the same segment. For the axis particle of point k its
                   diagonal[k] goes to the block on the diagonal, next[k] to that which couples it to the axis particle
                   of point k + 1: both lie in the band of its strand, and so in its factors.
    O              `multiply_across`: terms between points of the two segments of a coupling, also where both belong
                   to one strand; conjugate gradients multiply by it, `sim/contact/conjugate.py`.

The right-hand side of the strands gets `add_push`. Rows of held particles (roots) are fixed after all of that. Which
couplings touch a point is found once, by `find_incidence`, and holds as long as `segments` stay what they are; every
point gathers from its own list, in the order of the couplings, so that no result depends on threads.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined

_CHUNK = 2048
"""Points that are gathered one after the other."""


class Couplings(NamedTuple):
    """A set of couplings.

    segments   a segment joins a point to the next of its strand and has its number, (n, 2) int32
    fractions  where on the segments, 0 at that point and 1 at the next, (n, 2)
    push       impulse on the first point, the opposite on the second [N s], (n, 3)
    matrix     M, positive semidefinite: xx xy xz yy yz zz [kg], (n, 6)
    """

    segments: np.ndarray
    fractions: np.ndarray
    push: np.ndarray
    matrix: np.ndarray


class Incidence(NamedTuple):
    """Which couplings touch a segment.

    first  those of segment k are sides[first[k]:first[k+1]], (points+1,) int32
    sides  2 i + j: coupling i, of which the segment is the first (j = 0) or the second (j = 1), ascending, (2 n,) int32
    """

    first: np.ndarray
    sides: np.ndarray


def no_couplings() -> Couplings:
    """Make an empty set."""
    return Couplings(np.empty((0, 2), np.int32), np.empty((0, 2)), np.empty((0, 3)), np.empty((0, 6)))


def joined(sets: list[Couplings]) -> Couplings:
    """Put sets behind one another."""
    return Couplings(*(np.concatenate(parts) for parts in zip(no_couplings(), *sets, strict=True)))


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


@njit(cache=True, parallel=True)
def own_blocks(couplings: Couplings, incidence: Incidence, diagonal: np.ndarray, following: np.ndarray) -> None:
    """Add the terms between points of one segment, in place.

    diagonal   between a point and itself, symmetric [kg], (points, 6)
    following  between a point and the next of its strand, symmetric too [kg], (points, 6)
    """
    for chunk in prange(-(-len(diagonal) // _CHUNK)):
        _blocks_of_some(couplings, incidence, diagonal, following, np.int64(chunk) * _CHUNK)


@njit(cache=True, parallel=True)
def multiply_across(couplings: Couplings, incidence: Incidence, v: np.ndarray, out: np.ndarray) -> None:
    """Add O v, the terms between points of different sides of a coupling, in place.

    v    [m/s], (points, 3)
    out  [N s], (points, 3)
    """
    for chunk in prange(-(-len(out) // _CHUNK)):
        _multiply_some(couplings, incidence, v, out, np.int64(chunk) * _CHUNK)


@inlined
def _add_to_point(out, k, sign, near, carried):  # noqa: ANN001, ANN202
    """Add what a point gets from its own segment and from the one before it."""
    out[k, 0] += sign * (near[0] + carried[0])
    out[k, 1] += sign * (near[1] + carried[1])
    out[k, 2] += sign * (near[2] + carried[2])


@inlined
def _grow(sums, weight, y):  # noqa: ANN001, ANN202
    return sums[0] + weight * y[0], sums[1] + weight * y[1], sums[2] + weight * y[2]


@njit(cache=True)
def _push_some(couplings, incidence, out, begin):  # noqa: ANN001, ANN202
    """Walk along the segments of a chunk: each gives the part of its own point, and carries that of the next."""
    first, sides, push, fractions = incidence.first, incidence.sides, couplings.push, couplings.fractions
    carried = (0.0, 0.0, 0.0)
    for k in range(max(begin - 1, 0), min(begin + _CHUNK, len(out))):
        near, far = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for e in range(first[k], first[k + 1]):
            i, j = sides[e] >> 1, sides[e] & 1
            sign, s = 1.0 - 2.0 * j, fractions[i, j]
            near = _grow(near, sign * (1.0 - s), push[i])
            far = _grow(far, sign * s, push[i])
        if k >= begin:
            _add_to_point(out, k, 1.0, near, carried)
        carried = far


@njit(cache=True)
def _multiply_some(couplings, incidence, v, out, begin):  # noqa: ANN001, ANN202
    """Walk as `_push_some`."""
    first, sides, fractions = incidence.first, incidence.sides, couplings.fractions
    segments, M = couplings.segments, couplings.matrix
    carried = (0.0, 0.0, 0.0)
    for k in range(max(begin - 1, 0), min(begin + _CHUNK, len(out))):
        near, far = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for e in range(first[k], first[k + 1]):
            i, j = sides[e] >> 1, sides[e] & 1
            s, t, q = fractions[i, j], fractions[i, 1 - j], segments[i, 1 - j]
            a = (1.0 - t) * v[q, 0] + t * v[q + 1, 0]
            b = (1.0 - t) * v[q, 1] + t * v[q + 1, 1]
            c = (1.0 - t) * v[q, 2] + t * v[q + 1, 2]
            y = (
                M[i, 0] * a + M[i, 1] * b + M[i, 2] * c,
                M[i, 1] * a + M[i, 3] * b + M[i, 4] * c,
                M[i, 2] * a + M[i, 4] * b + M[i, 5] * c,
            )
            near = _grow(near, 1.0 - s, y)
            far = _grow(far, s, y)
        if k >= begin:
            _add_to_point(out, k, -1.0, near, carried)
        carried = far


@njit(cache=True)
def _blocks_of_some(couplings, incidence, diagonal, following, begin):  # noqa: ANN001, ANN202
    """Walk as `_push_some`."""
    first, sides, fractions, M = incidence.first, incidence.sides, couplings.fractions, couplings.matrix
    carried, near, far = np.zeros(6), np.zeros(6), np.zeros(6)
    for k in range(max(begin - 1, 0), min(begin + _CHUNK, len(diagonal))):
        near[:] = 0.0
        far[:] = 0.0
        for e in range(first[k], first[k + 1]):
            i, s = sides[e] >> 1, fractions[sides[e] >> 1, sides[e] & 1]
            for c in range(6):
                near[c] += (1.0 - s) * (1.0 - s) * M[i, c]
                far[c] += s * s * M[i, c]
                if k >= begin:
                    following[k, c] += s * (1.0 - s) * M[i, c]
        for c in range(6):
            if k >= begin:
                diagonal[k, c] += near[c] + carried[c]
            carried[c] = far[c]


@njit(cache=True, parallel=True)
def exchanged(couplings: Couplings, change: np.ndarray) -> Couplings:
    """Return couplings whose push is the impulse of a solve that changed velocities so; pure.

    push - M J dv [N s], for a change dv of the velocity of points [m/s], (points, 3)
    """
    push, M, fractions, segments = (
        np.empty_like(couplings.push),
        couplings.matrix,
        couplings.fractions,
        couplings.segments,
    )
    for i in prange(len(push)):
        k, q, s, t = segments[i, 0], segments[i, 1], fractions[i, 0], fractions[i, 1]
        x = (1.0 - s) * change[k, 0] + s * change[k + 1, 0] - (1.0 - t) * change[q, 0] - t * change[q + 1, 0]
        y = (1.0 - s) * change[k, 1] + s * change[k + 1, 1] - (1.0 - t) * change[q, 1] - t * change[q + 1, 1]
        z = (1.0 - s) * change[k, 2] + s * change[k + 1, 2] - (1.0 - t) * change[q, 2] - t * change[q + 1, 2]
        push[i, 0] = couplings.push[i, 0] - M[i, 0] * x - M[i, 1] * y - M[i, 2] * z
        push[i, 1] = couplings.push[i, 1] - M[i, 1] * x - M[i, 3] * y - M[i, 4] * z
        push[i, 2] = couplings.push[i, 2] - M[i, 2] * x - M[i, 4] * y - M[i, 5] * z
    return Couplings(segments, fractions, push, M)
