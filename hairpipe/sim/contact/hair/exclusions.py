"""Pairs excluded from contact: connected by stiction, or close to each other in the groom.

A set of pairs is a sorted array of keys without duplicates, see `key_of`.
"""

import numpy as np
from numba import njit

REST = 1.5
"""Pairs that the groom has within so many thicknesses are ignored for ever, as in the authors' code."""


def union(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the union of two sets of pairs, (n,) and (m,) int64; pure."""
    out = np.empty(len(a) + len(b), np.int64)
    return out[: _unite(a, b, out)]


def intersection(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the pairs that are in both of two sets, (n,) and (m,) int64; pure."""
    return np.intersect1d(a, b, assume_unique=True)


@njit(cache=True)
def _unite(a, b, out):
    i, j, count = 0, 0, 0
    while i < len(a) and j < len(b):
        out[count] = min(a[i], b[j])
        i, j = i + (a[i] == out[count]), j + (b[j] == out[count])  # A key in both sets moves both on: written once.
        count += 1
    for left in (a[i:], b[j:]):
        out[count : count + len(left)] = left
        count += len(left)
    return count
