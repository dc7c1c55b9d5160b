"""Pairs of segments that are among each other's closest few."""

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined
from hairpipe.sim.contact.closest import closest_of
from hairpipe.sim.contact.near import near_pairs_of
from hairpipe.sim.contact.pairs import Pairs, chosen
from hairpipe.sim.contact.segments import all_segments, refuse_lost

_PARTS = 8
"""Of all segments, ranked at a time."""


def closest_pairs(
    points: np.ndarray,
    offsets: np.ndarray,
    reach: float,
    most: int,
    ignored: np.ndarray | None = None,
    room: np.ndarray | None = None,
) -> Pairs:
    """List pairs of segments within reach [m] that are among each other's closest; pure.

    points   [m], (P, 3) float64
    offsets  strand s owns points offsets[s] : offsets[s + 1], (S + 1,) int32
    most     so many closest of each segment count; of equally close ones those with the lower number
    ignored  sorted keys of pairs to leave out, see `key_of`, (k,) int64
    room     a segment's own limit below `most`; one with 0 is passed over as if it were not there, (P,)

    No segment is in more pairs than its limit. Raises ArithmeticError where a position is not finite.
    """
    limits = np.full(len(points), most) if room is None else np.minimum(room, most)
    refuse_lost(points)
    segments = all_segments(len(points), offsets)
    near = near_pairs_of(points, segments[limits[segments] > 0], reach, ignored)
    closest = np.full((len(points), most), -1, np.int32)
    _rank(points, near.segments, near.distances, limits, closest)
    mutual = np.empty(len(near.distances), np.bool_)
    _find_mutual(near.segments, closest, mutual)
    return chosen(near, mutual)


@njit(cache=True, parallel=True)
def _rank(points, segments, distances, limits, closest):  # noqa: ANN001, ANN202
    """List for every segment the pairs in which it is closest to others, as many as its limit, the closest first.

    In lexicographic order pairs with one segment come by the number of the other.
    """
    for part in prange(_PARTS):
        start, end = len(limits) * part // _PARTS, len(limits) * (part + 1) // _PARTS
        for pair in range(np.searchsorted(segments[:, 0], end)):
            for i in (segments[pair, 0], segments[pair, 1]):
                if start <= i < end:
                    _enter(pair, points, segments, distances, closest[i, : limits[i]])


@inlined
def _enter(pair, points, segments, distances, row):  # noqa: ANN001, ANN202
    """Enter a pair into a row of pairs, behind those that are as close, if there is a place."""
    place = len(row)
    while place > 0 and (row[place - 1] < 0 or _is_closer(pair, row[place - 1], points, segments, distances)):
        if place < len(row):
            row[place] = row[place - 1]
        place -= 1
    if place < len(row):
        row[place] = pair


@inlined
def _is_closer(pair, other, points, segments, distances):  # noqa: ANN001, ANN202
    """Whether one pair is closer than another, by squares where their roots are the same."""
    if distances[pair] != distances[other]:
        return distances[pair] < distances[other]
    return _squared(points, segments, pair) < _squared(points, segments, other)


@inlined
def _squared(points, segments, pair):  # noqa: ANN001, ANN202
    return closest_of(points, segments[pair, 0], segments[pair, 1])[2]


@njit(cache=True, parallel=True)
def _find_mutual(segments, closest, mutual):  # noqa: ANN001, ANN202
    """Mark the pairs that both of their segments list."""
    for pair in prange(len(segments)):
        mutual[pair] = _lists(closest[segments[pair, 0]], pair) and _lists(closest[segments[pair, 1]], pair)


@inlined
def _lists(row: np.ndarray, pair: int) -> bool:
    found = False
    for k in range(len(row)):
        found |= row[k] == pair
    return found
