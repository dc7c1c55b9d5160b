"""Visible segments of hair in each tile of the film, the nearest first."""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.render.camera import NEAR
from hairpipe.render.raster.fragments import BLOCK, SKIN, farthest

TILE = 64
"""Pixels across a tile: its buffer stays in the processor's cache."""
LEVELS = 65535
"""Steps of depth by which segments are ordered."""


class Curves(NamedTuple):
    """Strands on the film, and their visible segments.

    places   column [pixels], row [pixels] and depth [m] of the points, (p, 3) float64
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,)
    strand   of every point, (p,) int32
    widths   of the points times the focal length [m pixels], (p,)
    starts   points at which segments begin, by their least depth, (n,) int64
    boxes    first and last blocks of rows and of columns that they may touch, (n, 4) int16
    nearest  their least depth [m], (n,) float32
    """

    places: np.ndarray
    offsets: np.ndarray
    strand: np.ndarray
    widths: np.ndarray
    starts: np.ndarray
    boxes: np.ndarray
    nearest: np.ndarray


def lay_curves(places: np.ndarray, offsets: np.ndarray, width: float | np.ndarray, depth: np.ndarray) -> Curves:
    """Find the segments that are on the film and not behind the body, and order them; pure.

    places   column [pixels], row [pixels], depth [m] of the points, (p, 3) float64; depth <= NEAR is not seen
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,)
    width    of strands, or of the points, (p,), times the focal length [m pixels]
    depth    of the body [m], (height, width)

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

    far   depth from which a block is opaque [m]
    film  its height and width [pixels]

    A segment lies within the control points of its curve in Bezier's form, p1, p1 + (p2 - p0)/6, p2 - (p3 - p1)/6, p2.
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
    """List the segments of every tile, in the order given; `rows` and `columns` are numbers of tiles.

    boxes  first and last block of rows and of columns, (n, 4)

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
