"""Visible triangle at every pixel."""

import math

import numpy as np
from numba import njit

UNSEEN = -1
Place = tuple[float, float]
"""Column and row on the film [pixels]."""


@njit(cache=True, nogil=True)
def rasterise(
    film: np.ndarray, triangles: np.ndarray, closeness: np.ndarray, height: int, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """Find the closest triangle over every pixel centre; of equals the first in order.

    film       column and row of the vertices [pixels], (n, 2) float64
    triangles  vertex indices, (m, 3); triangles with a vertex of closeness <= 0 are omitted
    closeness  greater is closer; linear on the film, as 1/depth is in perspective, (n,) float64
    height     of the film [pixels]
    width      of the film [pixels]

    Returns the index of the visible triangle, or UNSEEN, (height, width) int32, and its closeness, or 0,
    (height, width) float64.
    """
    seen = np.full((height, width), UNSEEN, np.int32)
    best = np.zeros((height, width))
    for m in range(len(triangles)):
        a, b, c = triangles[m]
        ax, ay, bx, by, cx, cy = film[a, 0], film[a, 1], film[b, 0], film[b, 1], film[c, 0], film[c, 1]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)  # Signed, so that weights are positive inside either way.
        if area == 0.0 or min(closeness[a], closeness[b], closeness[c]) <= 0.0:
            continue
        for i in range(first_centre(min(ay, by, cy), height), first_centre(max(ay, by, cy), height)):
            for j in range(first_centre(min(ax, bx, cx), width), first_centre(max(ax, bx, cx), width)):
                u, v, w = weights((ax, ay), (bx, by), (cx, cy), area, j + 0.5, i + 0.5)
                if u < 0.0 or v < 0.0 or w < 0.0:
                    continue
                close = u * closeness[a] + v * closeness[b] + w * closeness[c]
                if close > best[i, j]:  # Not >=: of equals the first in order stays.
                    best[i, j] = close
                    seen[i, j] = m
    return seen, best


@njit(cache=True, nogil=True, inline="always")
def weights(a: Place, b: Place, c: Place, area: float, x: float, y: float) -> tuple[float, float, float]:
    """Return the barycentric coordinates of the film point (x, y) in the triangle abc of twice this signed area."""
    u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
    v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
    return u, v, 1.0 - u - v


@njit(cache=True, nogil=True, inline="always")
def first_centre(x: float, size: int) -> int:
    """Index of the first pixel whose centre is not before x, held within 0..size, for x of any magnitude."""
    return math.ceil(min(max(x, 0.0), size + 0.5) - 0.5)
