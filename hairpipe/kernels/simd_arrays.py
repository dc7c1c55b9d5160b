"""Arrays of lanes, row by row.

In a kernel, numpy's own expressions on arrays leave single precision and take ten times as long to compile.
"""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import load, store

_CHUNK = 64
"""Rows that one thread goes over at a time."""


@inlined
def difference(x, p, q):
    """Return the vector of lanes x_q - x_p from an array x (rows, 3, W)."""
    return load(x, (q, 0)) - load(x, (p, 0)), load(x, (q, 1)) - load(x, (p, 1)), load(x, (q, 2)) - load(x, (p, 2))


@inlined
def combine(out, a, x, b, y):
    """Set out to a x + b y, in place; a and b numbers, the others (particles, components, W)."""
    for p in range(out.shape[0]):
        for c in range(out.shape[1]):
            store(out, (p, c), a * load(x, (p, c)) + b * load(y, (p, c)))


@inlined
def fill(out, value):
    """Set all of out, (particles, components, W), to a number, in place."""
    for p in range(out.shape[0]):
        for c in range(out.shape[1]):
            store(out, (p, c), value)


@inlined
def copy(out, x):
    """Set out to x, in place; both (particles, components, W)."""
    for p in range(out.shape[0]):
        for c in range(out.shape[1]):
            store(out, (p, c), load(x, (p, c)))


def zeros_like(x: np.ndarray) -> np.ndarray:
    """Make zeros of the shape and dtype of x, (rows, components, W)."""
    out = np.empty_like(x)
    _fill_all(out, out.dtype.type(0.0))
    return out


@njit(cache=True, parallel=True)
def _fill_all(out, value):
    for n in prange((out.shape[0] + _CHUNK - 1) // _CHUNK):
        fill(out[np.int64(n) * _CHUNK : (np.int64(n) + 1) * _CHUNK], value)


def copied(x: np.ndarray) -> np.ndarray:
    """Copy x, (rows, components, W)."""
    out = np.empty_like(x)
    _copy_all(out, x)
    return out


@njit(cache=True, parallel=True)
def _copy_all(out, x):
    for n in prange((out.shape[0] + _CHUNK - 1) // _CHUNK):
        rows = slice(np.int64(n) * _CHUNK, (np.int64(n) + 1) * _CHUNK)
        copy(out[rows], x[rows])


@njit(cache=True, parallel=True)
def combine_all(out, a, x, b, y):
    """Set out, which may be x or y, to a x + b y for all strands, in place; a and b numbers, the others
    (rows, components, W).
    """
    for n in prange((out.shape[0] + _CHUNK - 1) // _CHUNK):  # Rows are independent, so that out may be x or y.
        rows = slice(np.int64(n) * _CHUNK, (np.int64(n) + 1) * _CHUNK)
        combine(out[rows], a, x[rows], b, y[rows])
