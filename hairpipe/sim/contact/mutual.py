"""Pairs of segments that stand in each other's list."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange


class Lists(NamedTuple):
    """The closest segments of each.

    closest  first the closest, -1 where there is none, (P, most) int32
    squared  distances [m^2], inf where there is none, (P, most)
    """

    closest: np.ndarray
    squared: np.ndarray


def mutual_pairs(closest: np.ndarray) -> np.ndarray:
    """List the pairs of which each is among the other's closest, (P, most), in order, (n, 2) int32; pure."""
    starts = np.zeros(len(closest) + 1, np.int64)
    _count(closest, starts)
    np.cumsum(starts, out=starts)
    pairs = np.empty((starts[-1], 2), np.int32)
    _list(closest, starts, pairs)
    return pairs


@njit(cache=True)
def _is_mutual(closest, i, j):  # noqa: ANN001, ANN202
    """Whether j, of the list of i, is higher than i and has i in its list."""
    found = False
    if j > i:
        for k in range(closest.shape[1]):
            found |= closest[j, k] == i
    return found


@njit(cache=True, parallel=True)
def _count(closest, starts):  # noqa: ANN001, ANN202
    for i in prange(len(closest)):
        count = 0
        for k in range(closest.shape[1]):
            count += _is_mutual(closest, i, closest[i, k])
        starts[i + 1] = count


@njit(cache=True, parallel=True)
def _list(closest, starts, pairs):  # noqa: ANN001, ANN202
    for i in prange(len(closest)):
        end = starts[i]
        for k in range(closest.shape[1]):
            j = closest[i, k]
            if _is_mutual(closest, i, j):
                place = end
                while place > starts[i] and pairs[place - 1, 1] > j:
                    pairs[place] = pairs[place - 1]
                    place -= 1
                pairs[place, 0], pairs[place, 1] = i, j
                end += 1
