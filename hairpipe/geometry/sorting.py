"""Stream compaction, radix sort and Morton order, in parallel; no result depends on the number of threads.

Radix sort goes digit by digit from the lowest, each pass keeps the order of equal digits. Groups of keys count their
digits, so that each has places of its own.

A Morton curve fills space: points near each other are near in memory, too. Source: G. M. Morton, A Computer Oriented
Geodetic Data Base, IBM 1966: the bits of the coordinates, interleaved.
"""

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined

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
    whole = rows.ndim > 1
    _take(rows if whole else rows[:, None], places, out if whole else out[:, None])
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


_MOST_BITS = 21
"""Bits of a cell's number along an axis: three such numbers fill 64 bits."""
_FINE_BITS = 20
"""Bits along an axis where the index of the point needs none of the key."""


def spread(x: np.ndarray) -> np.ndarray:
    """Return int64 numbers of at most 21 bits, or in a kernel one of them, with two zeros before every bit."""
    x = (x | x << 32) & 0x1F00000000FFFF
    x = (x | x << 16) & 0x1F0000FF0000FF
    x = (x | x << 8) & 0x100F00F00F00F00F
    x = (x | x << 4) & 0x10C30C30C30C30C3
    return (x | x << 2) & 0x1249249249249249


_spread = inlined(spread)


def morton_order(points: np.ndarray) -> np.ndarray:
    """Return the order of points [m], (n, 3), along the curve through the cube around them, (n,) int64; pure.

    The last axis varies slowest. Points in one cell keep their order.
    """
    if not len(points):
        return np.empty(0, np.int64)
    extent = max(float(np.ptp(points, axis=0).max()), 1e-12)
    cells = ((points - points.min(axis=0)) / extent * (2**_FINE_BITS - 1)).astype(np.int64)
    codes = spread(cells[:, 0]) | spread(cells[:, 1]) << 1 | spread(cells[:, 2]) << 2
    return np.argsort(codes, kind="stable")


def morton_order_in_cube(points: np.ndarray, centre: np.ndarray, extent: float) -> np.ndarray:
    """Return the order of points [m], (n, 3), along the curve through a given cube, (n,) int64; pure, in parallel.

    centre  of the cube [m], (3,)
    extent  half its edge [m]; points outside belong to the cells at its faces

    The first axis varies slowest. Points in one cell keep their order. Cells are as fine as a key has bits left after
    the index of the point.
    """
    shift = len(points).bit_length()
    bits = min((63 - shift) // 3, _MOST_BITS)
    keys = np.empty(len(points), np.int64)
    _find_keys(points, centre, 2.0 ** (bits - 1) / max(extent, 1e-300), bits, shift, keys)
    keys = sorted_by_bits(keys, shift, shift + 3 * bits)
    _leave_index(keys, (1 << shift) - 1)
    return keys


@njit(cache=True, parallel=True)
def _leave_index(keys, mask):
    for k in prange(len(keys)):
        keys[k] &= mask


@njit(cache=True, parallel=True)
def _find_keys(points, centre, scale, bits, shift, keys):
    """Write a key of every point: the number of its cell on the curve, then the index of the point."""
    half = 1 << (bits - 1)
    for k in prange(len(points)):
        code = 0
        for axis in range(3):
            x = np.floor(scale * (points[k, axis] - centre[axis]))
            # Clamped as a float: far cells would overflow.
            code = code << 1 | _spread(int(min(max(x, -half), half - 1)) + half)
        keys[k] = code << shift | k
