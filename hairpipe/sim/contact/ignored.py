"""Pairs that hair takes no notice of: stuck together, or so close in the groom that they belong there.

A set of pairs is a sorted array of keys without duplicates, first * 2^32 + second of the segments' numbers, int64.
"""

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined
from hairpipe.sim.contact.pairs import Pairs

REST = 1.5
"""Pairs that the groom has within so many thicknesses are ignored for ever, as in the authors' code."""


def keys_of(segments: np.ndarray) -> np.ndarray:
    """Make a set of pairs, first < second in each, (n, 2) int32; gives (n,) int64."""
    return np.unique((segments[:, 0].astype(np.int64) << 32) | segments[:, 1])


def without(pairs: Pairs, ignored: np.ndarray) -> Pairs:
    """Take out the pairs of a set of keys; pure, and in the same order."""
    if not len(ignored):
        return pairs
    kept = np.empty(len(pairs.segments), np.bool_)
    _keep(kept, pairs.segments, ignored)
    return Pairs(pairs.segments[kept], pairs.fractions[kept], pairs.distances[kept])


@inlined
def is_in(keys, first, second):  # noqa: ANN001, ANN201
    """Whether the pair of segments first < second is in a set."""
    key, low, high = (np.int64(first) << 32) | np.int64(second), 0, len(keys)
    while low < high:
        middle = (low + high) >> 1
        if keys[middle] < key:
            low = middle + 1
        else:
            high = middle
    return low < len(keys) and keys[low] == key


@njit(cache=True, parallel=True)
def _keep(kept, segments, ignored):  # noqa: ANN001, ANN202
    for i in prange(len(kept)):
        kept[i] = not is_in(ignored, segments[i, 0], segments[i, 1])
