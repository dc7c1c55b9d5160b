"""Segments sorted into cells of space, so that those in a box are a few runs of neighbours in memory.

The grid is a torus: what is far off comes round into the same cells, is tested and found to be far off. So memory is
bounded by the number of segments, wherever they are. Cells run fastest along z: a column of them is one run.

In single precision and in units of a cell, from a place amid the hair, lie what sixteen tests at once need. Their
rounding is bounded: see `rounding`. What they let pass is measured in double precision.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined
from hairpipe.body.vectors import Vector, dot, minus, mix, times
from hairpipe.sim.contact.pieces import Pieces, piece, pieces_of
from hairpipe.sim.lanes import width

SINGLE = np.float32
LANES = width(SINGLE)
ULP = 2.0**-24
MOST_RUNS = 8192
"""Boxes of more columns of cells are not looked for: all of the grid is."""
_CELLS_PER_PIECE = 4
_FINEST = 1e-6
"""Least size of a cell [m]: the farthest are numbered in 64 bits."""
_SAMPLE = 1024


class Grid(NamedTuple):
    """Pieces of segments in the order of the cells that their midpoints are in.

    shape     cells along x, y and z, before it comes round, (3,) int64
    starts    cell c holds pieces starts[c] : starts[c + 1], (cells + 1,) int64
    order     which of the given pieces each is, (E,) int32
    segments  that they are of, (E,) int32
    numbers   of each piece in its segment, (E,) int32
    rows      for every piece x y z of its start, x y z from there to its end, the square of that length, and one over
              it or 0, in cells, (8, E + LANES) float32; the last ones are zero
    cut       segments longer than this are in pieces [m]
    centre    where x y z are zero [m], (3,)
    cell      its edge [m]
    half      of the longest piece, in cells
    """

    shape: np.ndarray
    starts: np.ndarray
    order: np.ndarray
    segments: np.ndarray
    numbers: np.ndarray
    rows: np.ndarray
    cut: float
    centre: np.ndarray
    cell: float
    half: float


def build_grid(points: np.ndarray, pieces: Pieces, reach: float, centre: np.ndarray | None = None) -> Grid:
    """Sort pieces of segments into cells that suit a search within reach [m]; points [m], (P, 3); pure.

    centre  where x y z are zero, for pieces that are looked for in another grid too; None: amid the points
    """
    some = points[:: max(1, len(points) // _SAMPLE)] if len(points) else np.zeros((1, 3))
    extent = np.ptp(some, axis=0)
    centre = np.median(some, axis=0) if centre is None else centre
    cell = max(0.5 * (reach + pieces.longest), _FINEST)
    shape = _shape(extent / cell, _CELLS_PER_PIECE * len(pieces.segments) + 64)
    cells = np.empty(len(pieces.segments), np.int64)
    _find_cells(points, pieces.segments, pieces.numbers, pieces.cut, centre, cell, shape, cells)
    starts, order = _sort(cells, shape.prod())
    rows = np.zeros((8, len(order) + LANES), SINGLE)
    segments, numbers = np.empty_like(pieces.segments), np.empty_like(pieces.numbers)
    _gather(points, pieces.segments, pieces.numbers, order, pieces.cut, centre, cell, segments, numbers, rows)
    half = 0.5 * pieces.longest / cell * (1.0 + 8 * ULP)
    return Grid(shape, starts, order, segments, numbers, rows, pieces.cut, centre, cell, half)


def _shape(extent: np.ndarray, most: int) -> np.ndarray:
    """Give the cells along each axis, for an extent in cells, as many as there may be."""
    shape = np.floor(extent) + 1.0
    while shape.prod() > most:
        shape[np.argmax(shape)] = np.ceil(shape.max() / 2.0)
    return shape.astype(np.int64)


@inlined
def in_cells(x: Vector, centre: np.ndarray, cell: float) -> Vector:
    """Return x [m] in cells from the centre, (3,)."""
    return times(1.0 / cell, minus(x, (centre[0], centre[1], centre[2])))


@njit(cache=True, parallel=True)
def _find_cells(points, segments, numbers, cut, centre, cell, shape, cells):  # noqa: ANN001, ANN202
    for k in prange(len(segments)):
        i = segments[k]
        a, b = piece(points, i, numbers[k], pieces_of(points, i, cut))
        middle = in_cells(mix(a, b, 0.5), centre, cell)
        x, y, z = int(np.floor(middle[0])), int(np.floor(middle[1])), int(np.floor(middle[2]))
        cells[k] = ((x % shape[0]) * shape[1] + y % shape[1]) * shape[2] + z % shape[2]


@njit(cache=True)
def _sort(cells, count):  # noqa: ANN001, ANN202
    """Return where each of so many cells starts, and the pieces in the order of cells; stable."""
    starts = np.zeros(count + 1, np.int64)
    for k in range(len(cells)):
        starts[cells[k] + 1] += 1
    for c in range(count):
        starts[c + 1] += starts[c]
    order = np.empty(len(cells), np.int32)
    for k in range(len(cells)):
        c = cells[k]
        order[starts[c]] = k
        starts[c] += 1
    for c in range(count, 0, -1):
        starts[c] = starts[c - 1]
    starts[0] = 0
    return starts, order


@njit(cache=True, parallel=True)
def _gather(points, segments, numbers, order, cut, centre, cell, sorted_segments, sorted_numbers, rows):  # noqa: ANN001, ANN202
    for e in prange(len(order)):
        k = order[e]
        i = segments[k]
        sorted_segments[e], sorted_numbers[e] = i, numbers[k]
        a, b = piece(points, i, numbers[k], pieces_of(points, i, cut))
        a, d = in_cells(a, centre, cell), times(1.0 / cell, minus(b, a))
        for x in range(3):
            rows[x, e], rows[3 + x, e] = a[x], d[x]
        square = SINGLE(dot(d, d))
        rows[6, e], rows[7, e] = square, SINGLE(1.0) / square if square > 0.0 else SINGLE(0.0)


@inlined
def find_runs(grid: Grid, low: Vector, high: Vector, first: int, runs: np.ndarray) -> int:
    """Write the runs of pieces from number `first` on that cover a box [cells], and return how many; in place.

    runs  starts and ends, (MOST_RUNS, 2) int64
    """
    nx, ny, nz = grid.shape[0], grid.shape[1], grid.shape[2]
    x0, y0, z0 = np.floor(low[0]), np.floor(low[1]), np.floor(low[2])
    kx, ky, kz = np.floor(high[0]) - x0 + 1.0, np.floor(high[1]) - y0 + 1.0, np.floor(high[2]) - z0 + 1.0
    kx, ky, kz = int(min(kx, nx)), int(min(ky, ny)), int(min(kz, nz))
    if 2 * kx * ky > len(runs):
        runs[0, 0], runs[0, 1] = first, len(grid.segments)
        return 1
    z = int(z0) % nz
    stop = z + kz
    x = int(x0) % nx
    count = 0
    for _ in range(kx):
        y = int(y0) % ny
        for _ in range(ky):
            column = (x * ny + y) * nz
            start, end = max(first, grid.starts[column + z]), grid.starts[column + min(stop, nz)]
            if start < end:
                runs[count, 0], runs[count, 1] = start, end
                count += 1
            if stop > nz:
                start, end = max(first, grid.starts[column]), grid.starts[column + stop - nz]
                if start < end:
                    runs[count, 0], runs[count, 1] = start, end
                    count += 1
            y = y + 1 if y + 1 < ny else 0
        x = x + 1 if x + 1 < nx else 0
    return count


@inlined
def entry(grid: Grid, e: int) -> tuple[Vector, Vector, float, float]:
    """Return the start of a piece and the way to its end [cells], the square of that and one over it."""
    rows = grid.rows
    return (rows[0, e], rows[1, e], rows[2, e]), (rows[3, e], rows[4, e], rows[5, e]), rows[6, e], rows[7, e]


@inlined
def reaching(p: Vector, d: Vector, radius: float) -> tuple[Vector, Vector]:
    """Return the corners of the box round everything within a radius of the segment from p to p + d [cells]."""
    low = (
        p[0] + min(d[0], 0.0) - radius,
        p[1] + min(d[1], 0.0) - radius,
        p[2] + min(d[2], 0.0) - radius,
    )
    high = (
        p[0] + max(d[0], 0.0) + radius,
        p[1] + max(d[1], 0.0) + radius,
        p[2] + max(d[2], 0.0) + radius,
    )
    return low, high


@inlined
def rounding(p: Vector, radius: float, half: float) -> tuple[float, float]:
    """Return by how much a distance [cells] to this piece may be misjudged, and its square beyond that.

    p       start of the piece, in cells
    radius  of what is looked for, half of the longest piece, in cells

    A coordinate x is rounded by ULP |x|: the first. The arithmetic of `distances`, with fractions that nearly parallel
    pieces leave uncertain, is off by less than 20 ULP (radius + 4 half)^2: see there.
    """
    far = max(abs(p[0]), max(abs(p[1]), abs(p[2]))) + radius + 4.0 * half + 1.0
    wide = radius + 4.0 * half
    return 8.0 * ULP * far, 128.0 * ULP * wide * wide
