"""Pairs of segments within a distance of each other, and those that are among each other's closest few."""

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.pair_search import in_order, search
from hairpipe.geometry.segment_distance import closest_of
from hairpipe.geometry.segment_tree import build_tree, find_frame
from hairpipe.geometry.segments import Pairs, all_segments, chosen, key_of, known_pairs, measure, refuse_lost
from hairpipe.geometry.vec3 import cross, dot, minus, row


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
    u, v = minus(row(points, i + 1), row(points, i)), minus(row(points, j + 1), row(points, j))
    n = cross(u, v)
    return dot(n, n) > CROSS * dot(u, u) * dot(v, v)


_PARTS = 8
"""Number of parts in which segments are ranked, in parallel."""


def closest_pairs(
    points: np.ndarray, pairs: Pairs, among: np.ndarray, most: int, room: np.ndarray | None = None
) -> Pairs:
    """List pairs of segments that are among each other's closest; pure.

    points  [m], (P, 3) float64
    pairs   in order; among  those that may be chosen, (n,) bool
    most    so many closest of each segment count; of equally close ones those with the lower number
    room    a segment's own limit below `most`; a segment with 0 is ignored, (P,)

    No segment is in more pairs than its limit.
    """
    limits = np.full(len(points), most) if room is None else np.minimum(room, most)
    near = chosen(pairs, _have_room(pairs.segments, among, limits))
    closest = np.empty((len(points), most), np.int32)
    _rank(points, near.segments, near.distances, limits, closest)
    mutual = np.empty(len(near.distances), np.bool_)
    _find_mutual(near.segments, closest, mutual)
    return chosen(near, mutual)


@njit(cache=True, parallel=True)
def _have_room(segments, among, limits):
    """Mark the pairs among some both of whose segments have a place left, (n,) bool."""
    have = np.empty(len(segments), np.bool_)
    for k in prange(len(segments)):
        have[k] = among[k] and limits[segments[k, 0]] > 0 and limits[segments[k, 1]] > 0
    return have


@njit(cache=True, parallel=True)
def _rank(points, segments, distances, limits, closest):
    """List for every segment the pairs in which it is closest to others, as many as its limit, the closest first.

    In lexicographic order pairs with one segment come by the number of the other.
    """
    for part in prange(_PARTS):
        start = len(limits) * part // _PARTS
        end = len(limits) * (part + 1) // _PARTS
        closest[start:end] = -1
        # Every part reads the pairs in order and enters those of its own segments: no two threads write one row.
        for pair in range(np.searchsorted(segments[:, 0], end)):
            for i in (segments[pair, 0], segments[pair, 1]):
                if start <= i < end:
                    _enter(pair, points, segments, distances, closest[i, : limits[i]])


@inlined
def _enter(pair, points, segments, distances, row):
    place = len(row)
    # Insertion behind equals: of pairs that are as close, the first in order stays, whatever the threads.
    while place > 0 and (row[place - 1] < 0 or _is_closer(pair, row[place - 1], points, segments, distances)):
        if place < len(row):
            row[place] = row[place - 1]
        place -= 1
    if place < len(row):
        row[place] = pair


@inlined
def _is_closer(pair, other, points, segments, distances):
    if distances[pair] != distances[other]:
        return distances[pair] < distances[other]
    # Squares may differ where their roots are the same.
    squared = closest_of(points, segments[pair, 0], segments[pair, 1])[2]
    return squared < closest_of(points, segments[other, 0], segments[other, 1])[2]


@njit(cache=True, parallel=True)
def _find_mutual(segments, closest, mutual):
    """Mark the pairs that both of their segments list."""
    for pair in prange(len(segments)):
        listed = 0
        for end in range(2):
            for k in range(closest.shape[1]):
                listed += closest[segments[pair, end], k] == pair
        mutual[pair] = listed == 2
