"""Pairs of segments within a distance of each other."""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.vec3 import cross, dot, minus, row
from hairpipe.spatial.pair_search import in_order, search
from hairpipe.spatial.pairs import Pairs, chosen, key_of, known_pairs, measure
from hairpipe.spatial.segment_tree import build_tree, find_frame
from hairpipe.spatial.segments import all_segments, refuse_lost


def near_pairs(
    points: np.ndarray,
    offsets: np.ndarray,
    reach: float,
    ignored: np.ndarray | None = None,
    widths: np.ndarray | None = None,
) -> Pairs:
    """List every pair of segments, of one strand too, that share no point and are within reach [m]; pure.

    points   [m], (P, 3) float64
    offsets  strand s owns points offsets[s] : offsets[s + 1], (S + 1,) int32
    ignored  sorted keys of pairs to leave out, see `key_of`, (k,) int64
    widths   of segments: two of widths a and b may be (a + b) / 2 of the reach apart, (P,); None: 1

    Raises LostPoints where a position is not finite.
    """
    pairs = pairs_about(points, offsets, reach, ignored, widths)
    wide = 1.0 if widths is None else widths[pairs.segments].mean(axis=1)
    return chosen(pairs, pairs.distances <= reach * wide)


def pairs_about(
    points: np.ndarray,
    offsets: np.ndarray,
    reach: float,
    ignored: np.ndarray | None = None,
    widths: np.ndarray | None = None,
) -> Pairs:
    """List near pairs and some that are farther, which a copy of all would be needed to leave out; see `near_pairs`.

    widths  of segments: two of widths a and b are near within (a + b) / 2 of the reach, (P,); None: 1
    """
    refuse_lost(points)
    segments = all_segments(offsets)
    tree = build_tree(points, None, segments, reach, find_frame(points, points, segments), widths)
    found = search(tree, tree, known_pairs(ignored, len(points)))
    return measure(points, in_order(found, len(points)))


CROSS = 0.5
"""Square of the sine of the angle above which two segments cross, and do not run along each other: 45 degrees. At 18
degrees a coarse knot, whose strand runs along itself, slips through itself."""


def approaches(pairs: Pairs, among: np.ndarray, points: np.ndarray) -> Pairs:
    """Keep the local minima of distance: of consecutive segments near the same one, the nearest; pure.

    pairs   in order; among  those that matter, (n,) bool
    points  [m], (P, 3)

    Where a strand runs along another one, most of its segments are near three of the other's. What is left are the
    contacts of two lines: one where they cross, at joints too, and one for every segment of the first where they run
    along each other. Without the first rule a joint that another strand slides over would push it back from its sides.
    """
    keep = _nearest(pairs.segments, pairs.distances, among)
    return chosen(pairs, _without_corners(pairs, key_of(pairs.segments), keep, points))


@njit(cache=True, parallel=True)
def _nearest(segments, distances, among):
    """Mark pairs among some whose second segment is not farther from the first than the one before or after it."""
    count = len(distances)
    keep = np.empty(count, np.bool_)
    for k in prange(count):
        first = segments[k, 0]
        second = segments[k, 1]
        distance = distances[k]
        # Rows are in order, and the last segment of a strand is not followed by the first of the next one.
        before = k > 0 and among[k - 1] and segments[k - 1, 0] == first and segments[k - 1, 1] == second - 1
        after = k + 1 < count and among[k + 1] and segments[k + 1, 0] == first and segments[k + 1, 1] == second + 1
        farther = (before and distances[k - 1] <= distance) or (after and distances[k + 1] < distance)
        keep[k] = among[k] and not farther
    return keep


@njit(cache=True, parallel=True)
def _without_corners(pairs, keys, keep, points):
    """Leave out of the pairs to keep those that cross at a joint of the first, where the next segment is nearer."""
    segments, fractions, distances = pairs.segments, pairs.fractions, pairs.distances
    kept = np.empty(len(keep), np.bool_)
    for k in prange(len(keep)):
        first, second, at = segments[k, 0], segments[k, 1], fractions[k, 0]
        kept[k] = keep[k]
        if keep[k] and (at == 0.0 or at == 1.0) and _cross(points, first, second):
            step = -1 if at == 0.0 else 1
            key = np.int64(first + step) << 32 | np.int64(second)
            beyond = np.searchsorted(keys, key)
            if beyond < len(keys) and keys[beyond] == key and keep[beyond]:
                farther = distances[k] - distances[beyond]
                kept[k] = farther < 0.0 or (farther == 0.0 and step > 0)
    return kept


@inlined
def _cross(points, i, j):
    """Whether two segments cross: |u x v|^2 > CROSS u.u v.v."""
    u, v = minus(row(points, i + 1), row(points, i)), minus(row(points, j + 1), row(points, j))
    n = cross(u, v)
    return dot(n, n) > CROSS * dot(u, u) * dot(v, v)
