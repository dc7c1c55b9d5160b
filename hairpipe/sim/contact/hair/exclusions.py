"""Pairs excluded from contact: connected by stiction, or close to each other in the groom.

A set of pairs is a sorted array of keys without duplicates, see `key_of`.
"""

import numpy as np
from numba import njit, prange

_PART = 1 << 15
"""Keys that one thread merges at a time."""
REST = 1.5
"""Pairs that the groom has within so many thicknesses are ignored for ever, as in the authors' code."""


def union(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the union of two sets of pairs, (n,) and (m,) int64; pure."""
    many, few = (a, b) if len(a) >= len(b) else (b, a)
    if not len(few):
        return many
    out = np.empty(len(a) + len(b), np.int64)
    parts = len(out) // _PART + 1
    of_many = len(many) * np.arange(parts + 1) // parts
    of_few = np.concatenate([[0], np.searchsorted(few, many[of_many[1:-1]]), [len(few)]])  # Equal keys: in one part.
    ends = np.empty(parts, np.int64)
    _unite(many, few, of_many, of_few, out, ends)
    begins = of_many + of_few
    if (ends == begins[1:]).all():
        return out
    return np.concatenate([out[begin:end] for begin, end in zip(begins.tolist(), ends.tolist(), strict=False)])


def intersection(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the pairs that are in both of two sets, (n,) and (m,) int64; pure."""
    return np.intersect1d(a, b, assume_unique=True)


@njit(cache=True, parallel=True)
def _unite(a, b, of_a, of_b, out, ends):
    """Merge parts of a and of b, which begin where stated, to out, each up to its end, in place."""
    for part in prange(len(ends)):
        i, j = of_a[part], of_b[part]
        i_end, j_end = of_a[part + 1], of_b[part + 1]
        place = i + j
        while i < i_end or j < j_end:
            from_a = j == j_end or (i < i_end and a[i] <= b[j])
            from_b = i == i_end or (j < j_end and b[j] <= a[i])
            out[place] = a[i] if from_a else b[j]
            i, j = i + from_a, j + from_b  # A key in both sets moves both on: written once.
            place += 1
        ends[part] = place
