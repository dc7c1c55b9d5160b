"""The order of points along a Morton curve, which fills space: points near each other are near in memory, too.

Source: G. M. Morton, A Computer Oriented Geodetic Data Base, IBM 1966: the bits of the coordinates, interleaved.
"""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.spatial.radix_sort import sorted_by_bits

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
def _find_keys(points, centre, scale, bits, shift, keys):
    """Write a key of every point: the number of its cell on the curve, then the index of the point."""
    for k in prange(len(points)):
        code = 0
        for axis in range(3):
            code = code << 1 | _spread(_cell(scale * (points[k, axis] - centre[axis]), bits))
        keys[k] = code << shift | k


@njit(cache=True, parallel=True)
def _leave_index(keys, mask):
    for k in prange(len(keys)):
        keys[k] &= mask


@inlined
def _cell(x: float, bits: int) -> int:
    """Return the number of the cell along an axis, of 2^bits."""
    half = 1 << (bits - 1)
    return int(min(max(np.floor(x), -half), half - 1)) + half  # Clamped as a float: far cells would overflow.
