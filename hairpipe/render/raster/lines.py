"""Hair as thin lines with exact coverage, sorted by depth in every pixel."""

import math

import numpy as np
from numba import njit, prange

from hairpipe.data.drawn_widths import TAPER
from hairpipe.render.camera import NEAR
from hairpipe.render.raster.fragments import BLOCK, Tile, add_fragment, develop_tile, make_tile
from hairpipe.render.raster.tiles import TILE, Curves, is_seen, list_by_tile
from hairpipe.render.raster.triangles import first_centre

BEND = 0.25
"""Largest deviation of a straight piece from its curve [pixels of the film]."""
MOST_PIECES = 16
"""Of a segment, however it bends."""
ROOT = 4.0
"""Length over which a strand widens from zero at its root, over its width."""


def draw_strands(film: np.ndarray, depth: np.ndarray, curves: Curves, colours: np.ndarray) -> None:
    """Draw strands over the film, in place; the same on any number of threads.

    film     linear red, green, blue, (height, width, 3) float32
    depth    of the body [m], (height, width)
    curves   visible segments of strands
    colours  linear, at every point and in the middle of the segment from there, (p, 2, 3) float64; only those of
             visible segments are read
    """
    rows, columns = -(-depth.shape[0] // TILE), -(-depth.shape[1] // TILE)
    draw_tiles(film, depth, curves, colours, *list_by_tile(curves.boxes, rows, columns), columns)


@njit(cache=True, nogil=True, parallel=True)
def draw_tiles(
    film: np.ndarray,
    depth: np.ndarray,
    curves: Curves,
    colours: np.ndarray,
    starts: np.ndarray,
    indices: np.ndarray,
    columns: int,
) -> None:
    """Draw the segments of every tile: tile t, in rows of `columns`, has indices[starts[t]:starts[t+1]]."""
    for t in prange(len(starts) - 1):  # Tiles are disjoint, and each draws in order: the same on any threads.
        place = TILE * (t // columns), TILE * (t % columns)
        draw_tile(film, depth, curves, colours, indices[starts[t] : starts[t + 1]], place)


@njit(cache=True, nogil=True)
def draw_tile(
    film: np.ndarray,
    depth: np.ndarray,
    curves: Curves,
    colours: np.ndarray,
    listed: np.ndarray,
    place: tuple[int, int],
) -> None:
    """Draw the segments listed over the tile that begins at this row and column of the film, in place."""
    if not len(listed):
        return
    top, left = place
    tile = make_tile(depth[top : top + TILE, left : left + TILE])
    ends = np.empty((2, 7))
    for n in listed:
        # Nearest segments come first: later ones are often behind an opaque block.
        if is_seen(tile.far, curves.boxes[n], curves.nearest[n], top // BLOCK, left // BLOCK):
            draw_segment(tile, ends, curves, colours, curves.starts[n], place)
    develop_tile(film[top : top + TILE, left : left + TILE], tile)


@njit(cache=True, nogil=True)
def draw_segment(
    tile: Tile, ends: np.ndarray, curves: Curves, colours: np.ndarray, i: int, place: tuple[int, int]
) -> None:
    """Draw the segment from point i as straight pieces in a tile that begins at this row and column of the film.

    A piece of n deviates from the curve c by at most max |c''| / (8 n^2); c'' is greatest at an end of the segment.
    n is even, since the colour has a knot in the middle.
    """
    first = curves.offsets[curves.strand[i]]
    last = curves.offsets[curves.strand[i] + 1] - 1
    terms = np.empty((3, 4))
    for d in range(3):
        terms[d] = catmull_rom(curves.places, d, i, first, last)
    begin = math.hypot(terms[0, 2], terms[1, 2])
    end = math.hypot(terms[0, 2] + 3.0 * terms[0, 3], terms[1, 2] + 3.0 * terms[1, 3])
    pieces = 2 + 2 * int(min(0.5 * math.sqrt(2.0 * max(begin, end) / (8.0 * BEND)), MOST_PIECES / 2 - 1.0))
    top, left = place
    a, b = ends
    lead = 1 if i == first else 0  # one more piece, in which a root widens
    for n in range(pieces + lead + 1):
        t = max(n - lead, 0) / pieces
        if lead and n == 1:
            t = min(
                ROOT * curves.widths[i] / terms[2, 0] / max(math.hypot(terms[0, 1], terms[1, 1]), 1e-9), 0.5 / pieces
            )
        for d in range(3):
            b[d] = terms[d, 0] + t * (terms[d, 1] + t * (terms[d, 2] + t * terms[d, 3]))
            outer = (1.0 - t) * colours[i, 0, d] + t * colours[i + 1, 0, d]
            middle = 0.5 * (colours[i, 0, d] + colours[i + 1, 0, d])
            b[4 + d] = outer + (1.0 - abs(2.0 * t - 1.0)) * (colours[i, 1, d] - middle)
        b[0], b[1] = b[0] - left, b[1] - top
        width = curves.widths[i] + t * (curves.widths[i + 1] - curves.widths[i])
        b[3] = width / max(b[2], NEAR) * math.sqrt(min(1.0, (last - i - t) / (last - first) / TAPER))
        if n < lead:
            b[3] = 0.0
        if n > 0:
            draw_line(tile, a, b)
        a, b = b, a  # The end of a piece is the beginning of the next one.


@njit(cache=True, nogil=True, inline="always")
def catmull_rom(places: np.ndarray, d: int, i: int, first: int, last: int) -> tuple[float, float, float, float]:
    """Return the terms of coordinate d of the segment from point i, a + t (b + t (c + t d)) (Catmull, Rom 1974).

    Beyond the ends of the strand, its points first and last, points are mirrored, as in the pinned curves of USD.
    """
    p1 = places[i, d]
    p2 = places[i + 1, d]
    p0 = places[i - 1, d] if i > first else 2.0 * p1 - p2
    p3 = places[i + 2, d] if i + 1 < last else 2.0 * p2 - p1
    return p1, 0.5 * (p2 - p0), p0 - 2.5 * p1 + 2.0 * p2 - 0.5 * p3, 1.5 * (p1 - p2) + 0.5 * (p3 - p0)


@njit(cache=True, nogil=True)
def draw_line(tile: Tile, a: np.ndarray, b: np.ndarray) -> None:
    """Add a straight line of any width to the pixels of a tile where no body is before it, in place.

    The line is cut along its longer direction into columns (or rows) at pixel centres; in each it covers an interval of
    the other direction, width / cos(slope) long, and every pixel is covered by its share of that interval. The coverage
    therefore sums to width times length, however thin the line, and lines that follow one another neither overlap nor
    leave a gap.

    a, b  column [pixels], row [pixels], depth [m], width [pixels], linear red, green, blue, (7,) float64
    """
    rows, columns = tile.limit.shape
    steep = abs(b[1] - a[1]) > abs(b[0] - a[0])
    major, minor = (1, 0) if steep else (0, 1)
    reach, size = (columns, rows) if steep else (rows, columns)
    if a[major] > b[major]:
        a, b = b, a
    start = a[major]
    run = b[major] - a[major]
    thick = 0.5 * math.hypot(run, b[minor] - a[minor]) / run if run > 0.0 else 0.0
    across = a[minor]
    z = a[2]
    half = thick * a[3]
    red = a[4]
    green = a[5]
    blue = a[6]
    d_across = b[minor] - across
    d_z = b[2] - z
    d_half = thick * b[3] - half
    d_red, d_green, d_blue = b[4] - red, b[5] - green, b[6] - blue
    for m in range(first_centre(start, size), first_centre(b[major], size)):
        t = (m + 0.5 - start) / run  # At pixel centres, so that consecutive lines neither share nor miss a column.
        middle, spread, at = across + t * d_across, half + t * d_half, z + t * d_z
        low = min(max(middle - spread, 0.0), reach)
        high = min(max(middle + spread, 0.0), reach)
        for k in range(int(low), min(int(high) + 1, reach)):
            row, column = (m, k) if steep else (k, m)
            cover = min(high, k + 1.0) - max(low, float(k))
            if cover > 0.0 and at < tile.limit[row, column]:  # Everything behind the limit is invisible.
                add_fragment(tile, row, column, at, cover, red + t * d_red, green + t * d_green, blue + t * d_blue)
