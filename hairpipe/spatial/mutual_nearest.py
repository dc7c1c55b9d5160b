"""Pairs of segments that are among each other's closest few."""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.spatial.pairs import Pairs, chosen
from hairpipe.spatial.segment_distance import closest_of

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
    """Enter a pair into a row of pairs, behind those that are as close, if there is a place."""
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
    """Whether one pair is closer than another, by squares where their roots are the same."""
    if distances[pair] != distances[other]:
        return distances[pair] < distances[other]
    return _squared(points, segments, pair) < _squared(points, segments, other)


@inlined
def _squared(points, segments, pair):
    return closest_of(points, segments[pair, 0], segments[pair, 1])[2]


@njit(cache=True, parallel=True)
def _find_mutual(segments, closest, mutual):
    """Mark the pairs that both of their segments list."""
    for pair in prange(len(segments)):
        mutual[pair] = _lists(closest[segments[pair, 0]], pair) and _lists(closest[segments[pair, 1]], pair)


@inlined
def _lists(row: np.ndarray, pair: int) -> bool:
    found = False
    for k in range(len(row)):
        found |= row[k] == pair
    return found
