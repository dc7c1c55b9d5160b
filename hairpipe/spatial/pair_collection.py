"""Pairs of segments that chunks of a tree find by themselves, put together and in order."""

from collections.abc import Callable

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.spatial.pairs import Known, is_known

CHUNK = 1024
"""Segments that one thread searches for at a time."""
_ROOM = 16
"""Pairs a segment that are made room for at first."""
_GROWTH = 2
"""Of the room, for chunks for which it was not enough."""
_GROUPS, _BUCKETS = 64, 1024
"""Parts of all pairs that are sorted at a time; parts by number of their first segment."""


def gather_pairs(search: Callable[..., None], pieces: int) -> np.ndarray:
    """Let all chunks of so many pieces search, and list what they find, (n, 2) int32.

    search  search(chunks, begins, found, counts, ends) writes what chunks (k,) find, each from one of its pieces on, to
            rows of found, (k, room, 2), as far as there is room, how many that are to counts, and where to go on to
            ends, (k,), in place; ends of CHUNK are those of chunks that are done

    What is dense goes on where it found no more room, with more of it.
    """
    chunks, room, rounds = np.arange(-(-pieces // CHUNK)), _ROOM * CHUNK, []
    begins, totals = np.zeros_like(chunks), np.zeros_like(chunks)
    while len(chunks):
        found, counts, ends = np.empty((len(chunks), room, 2), np.int32), np.zeros_like(chunks), np.empty_like(chunks)
        search(chunks, begins, found, counts, ends)
        rounds.append((chunks, totals[chunks], found, counts))
        totals[chunks] += counts
        chunks, begins, room = chunks[ends < CHUNK], ends[ends < CHUNK], _GROWTH * room
    starts, pairs = np.cumsum(totals) - totals, np.empty((totals.sum(), 2), np.int32)
    for chunks, before, found, counts in rounds:
        _collect(found, counts, starts[chunks] + before, pairs)
    return pairs


@inlined
def note(i: int, j: int, known: Known, found: np.ndarray, count: int) -> int:
    """Write pair i j to row `count` of found, if that is there and the pair is not known; return 1 if it is not."""
    first, second = min(i, j), max(i, j)
    if second - first <= 1 or is_known(known, first, second):
        return 0
    if count < len(found):
        found[count, 0], found[count, 1] = first, second
    return 1


@njit(cache=True, parallel=True)
def _collect(found, counts, starts, pairs):
    for c in prange(len(counts)):
        for k in range(counts[c]):
            pairs[starts[c] + k, 0], pairs[starts[c] + k, 1] = found[c, k, 0], found[c, k, 1]


def in_order(pairs: np.ndarray, points: int) -> np.ndarray:
    """Sort pairs of segments below `points`, (n, 2) int32, lexicographically; pure."""
    shift = max(0, int(points).bit_length() - _BUCKETS.bit_length() + 1)
    places = np.zeros((_GROUPS, (points >> shift) + 1), np.int64)
    _count(pairs, shift, places)
    ends = np.cumsum(places.T.ravel())
    places = np.ascontiguousarray((ends - places.T.ravel()).reshape(-1, _GROUPS).T)
    starts = np.append(places[0], len(pairs))
    buckets, order = np.empty_like(pairs), np.empty_like(pairs)
    _distribute(pairs, shift, places, buckets)
    _sort_buckets(buckets, shift, starts, order)
    return order


@njit(cache=True, parallel=True)
def _count(pairs, shift, places):
    groups = len(places)
    for g in prange(groups):
        for k in range(len(pairs) * g // groups, len(pairs) * (g + 1) // groups):
            places[g, pairs[k, 0] >> shift] += 1


@njit(cache=True, parallel=True)
def _distribute(pairs, shift, places, buckets):
    groups = len(places)
    for g in prange(groups):
        for k in range(len(pairs) * g // groups, len(pairs) * (g + 1) // groups):
            b = pairs[k, 0] >> shift
            place = places[g, b]
            buckets[place, 0], buckets[place, 1] = pairs[k, 0], pairs[k, 1]
            places[g, b] = place + 1


@njit(cache=True, parallel=True)
def _sort_buckets(buckets, shift, starts, order):
    for b in prange(len(starts) - 1):
        start, end, lowest = starts[b], starts[b + 1], np.int64(b) << shift
        rows = np.zeros((1 << shift) + 1, np.int64)
        for k in range(start, end):
            rows[buckets[k, 0] - lowest + 1] += 1
        for i in range(1 << shift):
            rows[i + 1] += rows[i]
        seconds = np.empty(end - start, np.int32)
        for k in range(start, end):
            i = buckets[k, 0] - lowest
            seconds[rows[i]] = buckets[k, 1]
            rows[i] += 1
        for i in range(1 << shift):
            first = rows[i - 1] if i > 0 else 0
            _sort(seconds[first : rows[i]])
            for k in range(first, rows[i]):
                order[start + k, 0], order[start + k, 1] = lowest + i, seconds[k]


@njit(cache=True)
def _sort(row):
    """Sort a few numbers, or many, in place."""
    if len(row) > 32:
        row.sort()
        return
    for k in range(1, len(row)):
        value, place = row[k], k
        while place > 0 and row[place - 1] > value:
            row[place] = row[place - 1]
            place -= 1
        row[place] = value
