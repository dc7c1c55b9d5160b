"""Roots in an order that keeps neighbours together: hair that touches then lies close in memory, too.

Source: G. M. Morton, A Computer Oriented Geodetic Data Base, IBM 1966: the bits of the coordinates, interleaved.
"""

import numpy as np

_BITS = 20  # of each coordinate


def order_along_curve(points: np.ndarray) -> np.ndarray:
    """Return the order of points [m], (n, 3), along a Morton curve through the cube round them, (n,) int64; pure."""
    if not len(points):
        return np.empty(0, np.int64)
    extent = max(float(np.ptp(points, axis=0).max()), 1e-12)
    places = ((points - points.min(axis=0)) / extent * (2**_BITS - 1)).astype(np.int64)
    code = np.zeros(len(points), np.int64)
    for bit in range(_BITS):
        for axis in range(3):
            code |= ((places[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")
