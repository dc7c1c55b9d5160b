"""Places in the order of a curve that fills space: what follows one another on it lies together."""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined

_MOST_BITS = 21
"""Of the number of a cell along an axis: three fill 64 bits."""


def along_curve(places: np.ndarray, centre: np.ndarray, extent: float) -> np.ndarray:
    """Return in which order places [m], (n, 3), come along a Morton curve, (n,) int64; pure.

    centre, extent  of the cube that is filled, (3,), and half its edge [m]; what is outside comes with its faces

    Places in one of its cells keep their order.
    """
    shift = len(places).bit_length()
    bits = min((63 - shift) // 3, _MOST_BITS)
    keys = np.empty(len(places), np.int64)
    _find_keys(places, centre, 2.0 ** (bits - 1) / max(extent, 1e-300), bits, shift, keys)
    keys.sort()
    return keys & ((1 << shift) - 1)


@njit(cache=True, parallel=True)
def _find_keys(places, centre, scale, bits, shift, keys):
    """Put the number of the cell on the curve and that of the place into one."""
    for k in prange(len(places)):
        cell = 0
        for x in range(3):
            cell = cell << 1 | _spread(_cell(scale * (places[k, x] - centre[x]), bits))
        keys[k] = cell << shift | k


@inlined
def _cell(x: float, bits: int) -> int:
    """Return the number of the cell along an axis, of 2^bits."""
    half = 1 << (bits - 1)
    return int(min(max(np.floor(x), -half), half - 1)) + half


@inlined
def _spread(x: int) -> int:
    """Put two zeros before every one of 21 bits."""
    x = (x | x << 32) & 0x1F00000000FFFF
    x = (x | x << 16) & 0x1F0000FF0000FF
    x = (x | x << 8) & 0x100F00F00F00F00F
    x = (x | x << 4) & 0x10C30C30C30C30C3
    return (x | x << 2) & 0x1249249249249249
