"""Pairs of segments within a distance of each other."""

import numpy as np
from numba import njit, prange

from hairpipe.spatial.pair_search import in_order, search
from hairpipe.spatial.pairs import Pairs, chosen, known_pairs, measure
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


def approaches(pairs: Pairs, among: np.ndarray) -> Pairs:
    """Keep the local minima of distance: of consecutive segments near the same one, the nearest; pure.

    pairs  in order; among  those that matter, (n,) bool

    Where a strand runs along another one, most of its segments are near three of the other's. What is left are the
    contacts of two lines: one where they cross, at a joint of the second strand too, and one for every segment of the
    first where they run along each other.
    """
    return chosen(pairs, _nearest(pairs.segments, pairs.distances, among))


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
