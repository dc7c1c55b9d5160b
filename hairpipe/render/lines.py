"""Hair as thin lines with exact coverage, sorted by depth in every pixel, tile by tile, nearest segments first.

A pixel keeps its last KEPT fragments sorted (a k-buffer, Bavoil et al. 2007). For a further fragment, the nearest is
blended: lines are drawn nearly from front to back, so that nearer fragments do not follow.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.render.camera import NEAR
from hairpipe.render.surface import first_centre
from hairpipe.values.groom import TAPER

KEPT = 8  # fragments that a pixel keeps, a power of two
OPAQUE = 0.004  # transmittance below which nothing behind is drawn: a level of 8 bits
BLOCK = 8  # pixels across a block: lines behind all of its pixels are skipped at once
SKIN = 0.002  # depth below the skin over which hair fades [m]: roots lie on the mesh, hair rests on a coarser level set


class Tile(NamedTuple):
    """Pixels of a part of the film, (rows, columns)."""

    kept: np.ndarray  # rings of fragments: depth [m], cover, linear red, green and blue, (rows, columns, KEPT, 5)
    head: np.ndarray  # place of the nearest in its ring, (rows, columns) int32
    filled: np.ndarray  # number of kept fragments, (rows, columns) int32
    blended: np.ndarray  # light and transmittance of blended fragments, (rows, columns, 4) float32
    through: np.ndarray  # transmittance of blended and kept fragments, (rows, columns) float32
    sunk: np.ndarray  # depth at which hair is invisible below the skin [m], (rows, columns) float32
    limit: np.ndarray  # depth at which everything is invisible, also behind opaque hair [m], (rows, columns) float32
    far: np.ndarray  # greatest limit in every block, (rows/BLOCK, columns/BLOCK) float32


@njit(cache=True, nogil=True)
def make_tile(depth: np.ndarray) -> Tile:
    """Make an empty tile before a body, infinitely far where there is none [m]."""
    rows, columns = depth.shape
    limit = np.empty((rows, columns), np.float32)
    blended = np.zeros((rows, columns, 4), np.float32)
    for i in range(rows):
        for j in range(columns):
            limit[i, j] = depth[i, j] + SKIN
            blended[i, j, 3] = 1.0
    kept = np.empty((rows, columns, KEPT, 5), np.float32)
    head, filled = np.zeros((rows, columns), np.int32), np.zeros((rows, columns), np.int32)
    return Tile(kept, head, filled, blended, np.ones_like(limit), limit, limit.copy(), farthest(limit))


@njit(cache=True, nogil=True)
def farthest(limit: np.ndarray) -> np.ndarray:
    rows, columns = limit.shape
    far = np.zeros(((rows + BLOCK - 1) // BLOCK, (columns + BLOCK - 1) // BLOCK), np.float32)
    for i in range(rows):
        for j in range(columns):
            far[i // BLOCK, j // BLOCK] = max(far[i // BLOCK, j // BLOCK], limit[i, j])
    return far


@njit(cache=True, nogil=True)
def add_fragment(tile: Tile, i: int, j: int, z: float, cover: float, red: float, green: float, blue: float) -> None:
    """Add the cover of a line to pixel (i, j), in front of its limit, in place."""
    kept = tile.kept
    head = tile.head[i, j]
    count = tile.filled[i, j]
    cover *= min(1.0, (tile.sunk[i, j] - z) / SKIN)
    if count == KEPT:
        if z < kept[i, j, head, 0]:  # Nearer than all kept fragments: blended itself in place of the nearest.
            blend(tile, i, j, cover, red, green, blue)
            tile.through[i, j] *= 1.0 - cover
            return
        blend(tile, i, j, kept[i, j, head, 1], kept[i, j, head, 2], kept[i, j, head, 3], kept[i, j, head, 4])
        head = (head + 1) & (KEPT - 1)
        count = count - 1
        tile.head[i, j] = head
    place = count
    while place > 0 and kept[i, j, (head + place - 1) & (KEPT - 1), 0] > z:
        for c in range(5):
            kept[i, j, (head + place) & (KEPT - 1), c] = kept[i, j, (head + place - 1) & (KEPT - 1), c]
        place -= 1
    slot = (head + place) & (KEPT - 1)
    kept[i, j, slot, 0], kept[i, j, slot, 1] = z, cover
    kept[i, j, slot, 2], kept[i, j, slot, 3], kept[i, j, slot, 4] = red, green, blue
    tile.filled[i, j] = count + 1
    tile.through[i, j] *= 1.0 - cover
    if tile.through[i, j] < OPAQUE:
        last = kept[i, j, (head + count) & (KEPT - 1), 0]
        if last < tile.limit[i, j]:
            hide(tile, i, j, last)


@njit(cache=True, nogil=True, inline="always")
def blend(tile: Tile, i: int, j: int, cover: float, red: float, green: float, blue: float) -> None:
    """Blend a fragment behind those already blended, in place."""
    share = tile.blended[i, j, 3] * cover
    tile.blended[i, j, 0] += share * red
    tile.blended[i, j, 1] += share * green
    tile.blended[i, j, 2] += share * blue
    tile.blended[i, j, 3] -= share


@njit(cache=True, nogil=True)
def hide(tile: Tile, i: int, j: int, limit: float) -> None:
    top, left = i - i % BLOCK, j - j % BLOCK
    before, tile.limit[i, j] = tile.limit[i, j], limit
    if before < tile.far[i // BLOCK, j // BLOCK]:  # Another pixel sets the limit of the block.
        return
    deepest = np.float32(0.0)
    for a in range(top, min(top + BLOCK, tile.limit.shape[0])):
        for b in range(left, min(left + BLOCK, tile.limit.shape[1])):
            deepest = max(deepest, tile.limit[a, b])
            if deepest == before:  # Another pixel is as far: the limit of the block is unchanged.
                return
    tile.far[i // BLOCK, j // BLOCK] = deepest


@njit(cache=True, nogil=True)
def develop_tile(film: np.ndarray, tile: Tile) -> None:
    """Blend all fragments over this part of the film, (rows, columns, 3), in place; the tile cannot be used again."""
    rows, columns = tile.filled.shape
    for i in range(rows):
        for j in range(columns):
            for n in range(tile.filled[i, j]):
                _, cover, red, green, blue = tile.kept[i, j, (tile.head[i, j] + n) & (KEPT - 1)]
                blend(tile, i, j, cover, red, green, blue)
            for c in range(3):
                film[i, j, c] = film[i, j, c] * tile.blended[i, j, 3] + tile.blended[i, j, c]


TILE = 64  # pixels across a tile: its buffer stays in the processor's cache
LEVELS = 65535  # steps of depth by which segments are ordered


class Curves(NamedTuple):
    """Strands on the film, and their visible segments."""

    places: np.ndarray  # column [pixels], row [pixels] and depth [m] of the points, (p, 3) float64
    offsets: np.ndarray  # strand s owns points offsets[s]:offsets[s+1], (S+1,)
    strand: np.ndarray  # of every point, (p,) int32
    widths: np.ndarray  # of the points times the focal length [m pixels], (p,)
    starts: np.ndarray  # points at which segments begin, by their least depth, (n,) int64
    boxes: np.ndarray  # first and last blocks of rows and of columns that they may touch, (n, 4) int16
    nearest: np.ndarray  # their least depth [m], (n,) float32


def lay_curves(places: np.ndarray, offsets: np.ndarray, width: float | np.ndarray, depth: np.ndarray) -> Curves:
    """Find the segments that are on the film and not behind the body, and order them; pure.

    places  column [pixels], row [pixels], depth [m] of the points, (p, 3) float64; depth <= NEAR is not seen
    width   of strands, or of the points, (p,), times the focal length [m pixels]

    Steps of depth are equal in its logarithm, so that far outliers do not make them coarse.
    """
    strand = np.repeat(np.arange(len(offsets) - 1, dtype=np.int32), np.diff(offsets))
    boxes = np.empty((len(places), 4), np.int16)
    nearest = np.empty(len(places), np.float32)
    widths = np.broadcast_to(np.asarray(width, float), len(places)).copy()
    bound(boxes, nearest, places, offsets, strand, widths, farthest(depth + SKIN), (len(depth), depth.shape[1]))
    starts = np.flatnonzero(nearest < np.inf)
    logs = np.log(nearest[starts])
    least = logs.min(initial=np.inf)
    span = max(logs.max(initial=-np.inf) - least, 1e-6)
    starts = starts[np.argsort(((logs - least) * (LEVELS / span)).astype(np.uint16), kind="stable")]
    return Curves(places, offsets, strand, widths, starts, boxes[starts], nearest[starts])


@njit(cache=True, nogil=True)
def bound(
    boxes: np.ndarray,
    nearest: np.ndarray,
    places: np.ndarray,
    offsets: np.ndarray,
    strand: np.ndarray,
    widths: np.ndarray,
    far: np.ndarray,
    film: tuple[int, int],
) -> None:
    """Write blocks and least depth of the segment from every point, infinite for an invisible one.

    A segment lies within the control points of its curve in Bezier's form, p1, p1 + (p2 - p0)/6, p2 - (p3 - p1)/6, p2.
    A block is opaque from a depth `far` on [m].
    """
    low, high = np.empty(3), np.empty(3)
    for i in range(len(places)):
        first = offsets[strand[i]]
        last = offsets[strand[i] + 1] - 1
        nearest[i] = np.inf
        if i == last or min(places[max(i - 1, first), 2], places[i, 2], places[i + 1, 2]) <= NEAR:
            continue
        if places[min(i + 2, last), 2] <= NEAR:
            continue
        for d in range(3):
            p1 = places[i, d]
            p2 = places[i + 1, d]
            p0 = places[i - 1, d] if i > first else 2.0 * p1 - p2
            p3 = places[i + 2, d] if i + 1 < last else 2.0 * p2 - p1
            b1 = p1 + (p2 - p0) / 6.0
            b2 = p2 - (p3 - p1) / 6.0
            low[d], high[d] = min(min(p1, p2), min(b1, b2)), max(max(p1, p2), max(b1, b2))
        z = max(low[2], NEAR)
        half = max(widths[i], widths[i + 1]) / z + 1.0  # A pixel more than the width, for partly covered pixels.
        if high[0] + half <= 0.0 or high[1] + half <= 0.0 or low[0] - half >= film[1] or low[1] - half >= film[0]:
            continue
        boxes[i, 0] = int(max(low[1] - half, 0.0)) // BLOCK
        boxes[i, 1] = int(min(high[1] + half, film[0] - 1.0)) // BLOCK
        boxes[i, 2] = int(max(low[0] - half, 0.0)) // BLOCK
        boxes[i, 3] = int(min(high[0] + half, film[1] - 1.0)) // BLOCK
        if is_seen(far, boxes[i], z, 0, 0):
            nearest[i] = z


@njit(cache=True, nogil=True, inline="always")
def is_seen(far: np.ndarray, box: np.ndarray, nearest: float, top: int, left: int) -> bool:
    """Whether a depth is before the limit of a block in the box; limits begin at block (top, left)."""
    for i in range(max(box[0] - top, 0), min(box[1] - top + 1, far.shape[0])):
        for j in range(max(box[2] - left, 0), min(box[3] - left + 1, far.shape[1])):
            if nearest < far[i, j]:
                return True
    return False


@njit(cache=True, nogil=True)
def list_by_tile(boxes: np.ndarray, rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """List the segments of every tile, in the order given, by their boxes; `rows` and `columns` are numbers of tiles.

    Returns starts, (rows*columns + 1,) int64, and indices, int32: tile t has indices[starts[t]:starts[t+1]].
    """
    blocks = TILE // BLOCK
    starts = np.zeros(rows * columns + 1, np.int64)
    for n in range(len(boxes)):
        for i in range(boxes[n, 0] // blocks, boxes[n, 1] // blocks + 1):
            for j in range(boxes[n, 2] // blocks, boxes[n, 3] // blocks + 1):
                starts[i * columns + j + 1] += 1
    starts = np.cumsum(starts)
    ends = starts[:-1].copy()
    indices = np.empty(starts[-1], np.int32)
    for n in range(len(boxes)):  # In the order given, nearest first, so that every tile draws from front to back.
        for i in range(boxes[n, 0] // blocks, boxes[n, 1] // blocks + 1):
            for j in range(boxes[n, 2] // blocks, boxes[n, 3] // blocks + 1):
                t = i * columns + j
                indices[ends[t]] = n
                ends[t] += 1
    return starts, indices


BEND = 0.25  # largest deviation of a straight piece from its curve [pixels of the film]
MOST_PIECES = 16  # of a segment, however it bends
ROOT = 4.0  # length over which a strand widens from zero at its root, over its width


def draw_strands(film: np.ndarray, depth: np.ndarray, curves: Curves, colours: np.ndarray) -> None:
    """Draw strands over the film, (height, width, 3) float32, in front of a body, in place; equal on any threads.

    colours  linear, at every point and in the middle of the segment from there, (p, 2, 3); only those of visible
             segments are read
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
    leave a gap. Ends are column, row [pixels], depth [m], width [pixels], linear red, green, blue, (7,) float64.
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
