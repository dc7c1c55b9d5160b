"""Radix sort of integer keys in parallel: digit by digit from the lowest, each pass keeps the order of equal digits.

Groups of keys count their digits, so that each has places of its own: the order does not depend on threads.
"""

import numpy as np
from numba import njit, prange

_DIGIT = 11
"""Bits of a digit at most: places of all digits fit a cache."""
_GROUP, _MOST = 8192, 64
"""Keys of a group, and number of groups at most."""


def sorted_by_bits(keys: np.ndarray, low: int, high: int) -> np.ndarray:
    """Return keys, (n,) int64, in the order of their bits from low up to high; equal ones keep theirs; pure."""
    passes = max(1, -(-(high - low) // _DIGIT))
    digit = -(-(high - low) // passes)
    groups = min(len(keys) // _GROUP + 1, _MOST)
    for shift in range(low, high, max(digit, 1)):
        out = np.empty_like(keys)
        _distribute(keys, shift, np.zeros((groups, 1 << min(digit, high - shift)), np.int64), out)
        keys = out
    return keys


@njit(cache=True, parallel=True)
def _distribute(keys, shift, places, out):
    groups, digits = places.shape
    for g in prange(groups):
        for k in range(len(keys) * np.int64(g) // groups, len(keys) * (np.int64(g) + 1) // groups):
            places[g, keys[k] >> shift & digits - 1] += 1
    total = 0
    for digit in range(digits):
        for g in range(groups):
            count = places[g, digit]
            places[g, digit] = total
            total += count
    for g in prange(groups):
        for k in range(len(keys) * np.int64(g) // groups, len(keys) * (np.int64(g) + 1) // groups):
            digit = keys[k] >> shift & digits - 1
            out[places[g, digit]] = keys[k]
            places[g, digit] += 1
