"""Stream compaction in parallel: the places of marks, rows at places, and where runs of equal numbers begin."""

import numpy as np
from numba import njit, prange

_CHUNK = 4096
"""Marks that one thread counts at a time."""


def places_of(marks: np.ndarray) -> np.ndarray:
    """List the places of the marks that are set, of (n,) bool, ascending, (m,) int64; pure."""
    starts = np.zeros(-(-len(marks) // _CHUNK) + 1, np.int64)
    _count(marks, starts)
    places = np.empty(starts[-1], np.int64)
    _list(marks, starts, places)
    return places


@njit(cache=True, parallel=True)
def _count(marks, starts):
    for chunk in prange(len(starts) - 1):
        for k in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(marks))):
            starts[chunk + 1] += marks[k]
    for chunk in range(1, len(starts)):
        starts[chunk] += starts[chunk - 1]


@njit(cache=True, parallel=True)
def _list(marks, starts, places):
    for chunk in prange(len(starts) - 1):
        place = starts[chunk]
        for k in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(marks))):
            if marks[k]:
                places[place] = k
                place += 1


def rows_at(rows: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the rows at some places, (m,) int64, of (n,) or (n, k); pure."""
    out = np.empty((len(places), *rows.shape[1:]), rows.dtype)
    if rows.ndim == 1:
        _take(rows[:, None], places, out[:, None])
    else:
        _take(rows, places, out)
    return out


@njit(cache=True, parallel=True)
def _take(rows, places, out):
    for k in prange(len(places)):
        for c in range(out.shape[1]):
            out[k, c] = rows[places[k], c]


@njit(cache=True, parallel=True)
def runs_of(keys: np.ndarray, count: int) -> np.ndarray:
    """Find where keys of one number lie: those with number i from starts[i] on to starts[i + 1], (count + 1,) int32.

    keys  ascending, (n,) int64: numbers below the count, in the bits above 32
    """
    starts = np.empty(count + 1, np.int32)
    for k in prange(len(keys) + 1):  # A key fills the places behind the number before it, up to its own.
        first = (keys[k - 1] >> 32) + 1 if k > 0 else 0
        last = keys[k] >> 32 if k < len(keys) else count
        for i in range(first, last + 1):
            starts[i] = k
    return starts
