"""Hair as thin lines with exact coverage, drawn from the back to the front."""

import math

import numpy as np
from numba import njit

from hairpipe.render.camera import NEAR
from hairpipe.render.raster.triangles import first_centre

SKIN = 0.002
"""How far below the skin a hair is still seen [m]: roots lie on the mesh, and hair rests on a slightly coarser body."""
PIECE = 6.0
"""Pixels of the film that one straight piece of a curve covers, about."""
TAPER = 0.35
"""Part of a strand, at its tip, over which it narrows to nothing."""


def draw_strands(
    film: np.ndarray, depth: np.ndarray, places: np.ndarray, offsets: np.ndarray, colours: np.ndarray, width: float
) -> None:
    """Paint strands over the film, farthest segment first, in place.

    film     linear red, green, blue, (height, width, 3) float32
    depth    of the body [m], (height, width) float32
    places   column [pixels], row [pixels] and depth [m] of the points, (p, 3) float64; depth <= NEAR is not drawn
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,)
    colours  linear, at the points, (p, 3) float64
    width    of a strand times the focal length [m pixels]
    """
    inner = np.ones(len(places), bool)
    inner[offsets[1:] - 1] = False
    starts = np.flatnonzero(inner)
    middle = places[starts, 2] + places[starts + 1, 2]
    strand = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    paint(film, depth, places, offsets, colours, width, starts[np.argsort(-middle, kind="stable")], strand)


@njit(cache=True, nogil=True)
def paint(
    film: np.ndarray,
    depth: np.ndarray,
    places: np.ndarray,
    offsets: np.ndarray,
    colours: np.ndarray,
    width: float,
    order: np.ndarray,
    strand: np.ndarray,
) -> None:
    """Draw the segments that begin at the points `order`, one over another, as pieces of Catmull-Rom curves."""
    a, b = np.empty(7), np.empty(7)
    for i in order:
        first, last = offsets[strand[i]], offsets[strand[i] + 1] - 1
        if places[max(i - 1, first) : min(i + 3, last + 1), 2].min() <= NEAR:
            continue
        length = math.hypot(places[i + 1, 0] - places[i, 0], places[i + 1, 1] - places[i, 1])
        pieces = 1 + int(min(length / PIECE, 4.0))
        vertex(a, places, colours, i, 0.0, first, last, width)
        for n in range(pieces):
            vertex(b, places, colours, i, (n + 1) / pieces, first, last, width)
            draw_line(film, depth, a, b)
            a[:] = b


@njit(cache=True, nogil=True)
def vertex(
    out: np.ndarray,
    places: np.ndarray,
    colours: np.ndarray,
    i: int,
    t: float,
    first: int,
    last: int,
    width: float,
) -> None:
    """Column, row, depth, width and colour of a strand at parameter t of the segment from point i, into `out` (7,).

    p1 + t/2 (p2 - p0 + t (2 p0 - 5 p1 + 4 p2 - p3 + t (3 (p1 - p2) + p3 - p0))) between p1 and p2 (Catmull, Rom 1974);
    beyond the ends of the strand its points are mirrored, as in the pinned curves of USD.
    """
    for d in range(3):
        p1, p2 = places[i, d], places[i + 1, d]
        p0 = places[i - 1, d] if i > first else 2.0 * p1 - p2
        p3 = places[i + 2, d] if i + 1 < last else 2.0 * p2 - p1
        out[d] = p1 + 0.5 * t * (p2 - p0 + t * (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3 + t * (3.0 * (p1 - p2) + p3 - p0)))
        out[4 + d] = (1.0 - t) * colours[i, d] + t * colours[i + 1, d]
    left = (last - i - t) / (last - first)
    out[3] = width / max(out[2], NEAR) * math.sqrt(min(1.0, left / TAPER))


@njit(cache=True, nogil=True)
def draw_line(film: np.ndarray, depth: np.ndarray, a: np.ndarray, b: np.ndarray) -> None:
    """Paint a straight line of any width over the film where no body is before it, in place.

    The line is cut along its longer direction into columns (or rows) at pixel centres; in each it covers an interval of
    the other direction, width / cos(slope) long, and every pixel is covered by its share of that interval. The coverage
    therefore sums to width times length, however thin the line, and lines that follow one another neither overlap nor
    leave a gap.

    a, b  column [pixels], row [pixels], depth [m], width [pixels], linear red, green, blue, (7,) float64
    """
    height, width = depth.shape
    steep = abs(b[1] - a[1]) > abs(b[0] - a[0])
    major, minor = (1, 0) if steep else (0, 1)
    reach, size = (width, height) if steep else (height, width)
    if a[major] > b[major]:
        a, b = b, a
    start, run = a[major], b[major] - a[major]
    thick = 0.5 * math.hypot(run, b[minor] - a[minor]) / run if run > 0.0 else 0.0
    across, z, half, red, green, blue = a[minor], a[2], thick * a[3], a[4], a[5], a[6]
    d_across, d_z, d_half = b[minor] - across, b[2] - z, thick * b[3] - half
    d_red, d_green, d_blue = b[4] - red, b[5] - green, b[6] - blue
    for m in range(first_centre(start, size), first_centre(b[major], size)):
        t = (m + 0.5 - start) / run
        middle, spread = across + t * d_across, half + t * d_half
        low, high = min(max(middle - spread, 0.0), reach), min(max(middle + spread, 0.0), reach)
        for k in range(int(low), min(int(high) + 1, reach)):
            row, column = (m, k) if steep else (k, m)
            if z + t * d_z - SKIN < depth[row, column]:
                cover = min(high, k + 1.0) - max(low, float(k))
                film[row, column, 0] += cover * (red + t * d_red - film[row, column, 0])
                film[row, column, 1] += cover * (green + t * d_green - film[row, column, 1])
                film[row, column, 2] += cover * (blue + t * d_blue - film[row, column, 2])
