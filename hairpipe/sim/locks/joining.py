"""Formation of locks: lasting connections of stiction join their hairs, the pairs with most connections first.

In steady motion connections are nearly permanent, so hairs with many common connections move together. One hair of
each lock, its guide, is simulated; the others are interpolated (`carrying.py`).
"""

import numpy as np
from numba import njit

from hairpipe.sim.settings import Locks


def joined(
    leaders: np.ndarray,
    occupancy: np.ndarray,
    segments: np.ndarray,
    ages: np.ndarray,
    offsets: np.ndarray,
    locks: Locks,
) -> np.ndarray:
    """Return the lock of every strand, named by one of its guides, (S,) int32; pure.

    leaders    the guide of every strand, a guide's own for itself, (S,) int32
    occupancy  the same, with the previous guide for strands that will follow again, (S,) int32
    segments   connected segments of guides, (n, 2) int32; ages  number of frames of each connection, (n,)
    offsets    of the points of strands, (S+1,) int32

    Guides with equal numbers of segments are joined if the share `part` of these have lasting connections, up to the
    maximum size of a lock; ties are resolved by strand index.
    """
    lasted = segments[ages >= locks.after]
    strands = np.searchsorted(offsets, lasted, side="right") - 1
    strands = np.sort(strands[strands[:, 0] != strands[:, 1]], axis=1)
    counts = np.diff(offsets) - 1
    strands = strands[counts[strands[:, 0]] == counts[strands[:, 1]]]
    pairs, times = np.unique(strands, axis=0, return_counts=True)
    enough = times >= locks.part * counts[pairs[:, 0]]
    pairs, times = pairs[enough], times[enough]
    order = np.argsort(-times, kind="stable")
    sizes = np.bincount(occupancy, minlength=len(occupancy))
    return _unite(pairs[order], leaders, sizes, locks.most)


@njit(cache=True)
def _unite(pairs, leaders, sizes, most):
    """Join pairs of guides, (n, 2), one after the other; return the lock of every strand, (S,) int32."""
    parents = np.arange(len(leaders)).astype(np.int32)
    for k in range(len(pairs)):
        a, b = _root(parents, pairs[k, 0]), _root(parents, pairs[k, 1])
        if a != b and sizes[a] + sizes[b] <= most:  # What would make a lock too large is left out.
            first = min(a, b)  # The lower number names the lock, whatever the order in which it grew.
            second = max(a, b)
            parents[second] = first
            sizes[first] += sizes[second]
    locks = np.empty_like(leaders)
    for s in range(len(leaders)):
        locks[s] = _root(parents, leaders[s])
    return locks


@njit(cache=True)
def _root(parents, s):
    while parents[s] != s:
        parents[s] = parents[parents[s]]  # Path halving keeps the trees flat.
        s = parents[s]
    return s


def guides_of(locks: np.ndarray, leaders: np.ndarray, points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the guide of every strand, (S,) int32: the guide in its lock that is nearest to the mean; pure.

    locks    lock of each strand, as named by `joined`, (S,); leaders  previous guides, (S,) int32
    points   points of all strands [m], (P, 3)

    A guide is one of the strands simulated so far and keeps its own state: nothing is averaged.
    """
    out = leaders.copy()
    _choose(np.argsort(locks, kind="stable"), locks, leaders, points, offsets, out)
    return out


@njit(cache=True)
def _choose(order, locks, leaders, points, offsets, out):
    begin = 0
    while begin < len(order):
        end = begin
        while end < len(order) and locks[order[end]] == locks[order[begin]]:
            end += 1
        members = order[begin:end]
        fresh = False
        for s in members:
            fresh |= leaders[s] != leaders[members[0]]
        if fresh:  # Only locks that have grown choose again: a guide is changed as seldom as possible.
            best = _nearest_to_mean(members, leaders, points, offsets)
            for s in members:
                out[s] = best
        begin = end


@njit(cache=True)
def _nearest_to_mean(members, leaders, points, offsets):
    count = offsets[members[0] + 1] - offsets[members[0]]
    mean = np.zeros((count, 3))
    for s in members:
        for k in range(count):
            for c in range(3):
                mean[k, c] += points[offsets[s] + k, c] / len(members)
    best = members[0]
    least = np.inf
    for s in members:
        far = 0.0
        for k in range(count):
            for c in range(3):
                far += (points[offsets[s] + k, c] - mean[k, c]) ** 2
        if leaders[s] == s and far < least:  # Only a guide has a simulated state of its own.
            best, least = s, far
    return best
