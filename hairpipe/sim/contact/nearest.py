"""The closest few segments of every segment."""

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined
from hairpipe.body.vectors import dot, minus, times
from hairpipe.sim.contact.closest import closest_of
from hairpipe.sim.contact.distances import squared_distances
from hairpipe.sim.contact.found import CHUNK
from hairpipe.sim.contact.grid import (
    LANES,
    MOST_RUNS,
    SINGLE,
    Grid,
    build_grid,
    find_runs,
    in_cells,
    reaching,
    rounding,
)
from hairpipe.sim.contact.mutual import Lists, mutual_pairs
from hairpipe.sim.contact.pairs import Pairs, is_known, known_pairs, measure
from hairpipe.sim.contact.pieces import all_segments, cut_in_pieces, piece, pieces_of, refuse_lost
from hairpipe.sim.lanes import bits, lowest


def closest_pairs(
    points: np.ndarray,
    offsets: np.ndarray,
    reach: float,
    most: int,
    ignored: np.ndarray | None = None,
    room: np.ndarray | None = None,
) -> Pairs:
    """List pairs of segments within reach [m] that are among each other's closest; pure.

    points   [m], (P, 3) float64
    offsets  strand s owns points offsets[s] : offsets[s + 1], (S + 1,) int32
    most     so many closest of each segment count; of equally close ones those with the lower number
    ignored  sorted keys of pairs to leave out, see `key_of`, (k,) int64
    room     a segment's own limit below `most`; one with 0 is passed over as if it were not there, (P,)

    No segment is in more pairs than its limit. Raises ArithmeticError where a position is not finite.
    """
    limits = np.full(len(points), most) if room is None else np.minimum(room, most)
    refuse_lost(points)
    segments = all_segments(len(points), offsets)
    grid = build_grid(points, cut_in_pieces(points, segments[limits[segments] > 0], reach), reach)
    lists = Lists(np.full((len(points), most), -1, np.int32), np.empty((len(points), most)))
    _search(points, grid, reach, known_pairs(ignored, len(points)), limits, lists)
    return measure(points, mutual_pairs(lists.closest))


@njit(cache=True, parallel=True)
def _search(points, grid, reach, known, limits, lists):  # noqa: ANN001, ANN202
    """Fill the lists of all segments in the grid."""
    for chunk in prange(-(-len(grid.segments) // CHUNK)):
        runs = np.empty((MOST_RUNS, 2), np.int64)
        start = np.int64(chunk) * CHUNK
        for e in range(start, min(start + CHUNK, len(grid.segments))):
            i = grid.segments[e]
            if grid.numbers[e] == 0:  # the list of a segment has one writer, whatever it is cut into
                row = Lists(lists.closest[i, : limits[i]], lists.squared[i, : limits[i]])
                _fill(points, grid, reach, known, i, runs, row)


@inlined
def _fill(points: np.ndarray, grid: Grid, reach: float, known, i: int, runs: np.ndarray, row: Lists) -> None:  # noqa: ANN001
    """Fill the list of segment i."""
    for k in range(len(row.squared)):
        row.squared[k] = np.inf
    count = pieces_of(points, i, grid.cut)
    for number in range(count):
        a, b = piece(points, i, number, count)
        _look_round(points, grid, reach, known, i, a, b, runs, row)


@inlined
def _look_round(points, grid, reach, known, i, a, b, runs, row):  # noqa: ANN001, ANN202
    """Enter what is near a piece, from a to b, of segment i into its list."""
    p, d = in_cells(a, grid.centre, grid.cell), times(1.0 / grid.cell, minus(b, a))
    dd = dot(d, d)
    inverse = 1.0 / dd if dd > 0.0 else 0.0
    radius = reach / grid.cell + grid.half
    blur, excess = rounding(p, radius, grid.half)
    low, high = reaching(p, d, radius + blur)
    limit = _limit(row, reach, grid.cell, blur, excess)
    count = find_runs(grid, low, high, 0, runs)
    for k in range(count):
        r = _outwards(k, count)
        for start in range(runs[r, 0], runs[r, 1], LANES):
            squared = squared_distances(grid.rows, p, d, dd, inverse, start)
            near = bits(squared <= limit) & ((1 << min(runs[r, 1] - start, LANES)) - 1)
            while near != 0:
                j = grid.segments[start + lowest(near)]
                near &= near - 1
                if _enter(points, reach, known, i, j, row):
                    limit = _limit(row, reach, grid.cell, blur, excess)
                    near &= bits(squared <= limit)


@inlined
def _outwards(k: int, count: int) -> int:
    """Return a run from the middle on: what is closest is found early, and the rest passed over."""
    middle = (count - 1) // 2
    return middle + (k + 1) // 2 if k % 2 == 1 else middle - k // 2


@inlined
def _limit(row, reach, cell, blur, excess):  # noqa: ANN001, ANN202
    """Return up to which square of a distance [cells^2] in single precision a segment may still enter the list."""
    distance = min(np.sqrt(row.squared[-1]), reach) / cell + blur
    return SINGLE((distance * distance + excess) * (1.0 + 1e-6))


@inlined
def _enter(points: np.ndarray, reach: float, known, i: int, j: int, row: Lists) -> bool:  # noqa: ANN001
    """Enter segment j into the list of i where it belongs; return whether it does."""
    first, second = min(i, j), max(i, j)
    if second - first <= 1:
        return False
    squared = closest_of(points, first, second)[2]
    if np.sqrt(squared) > reach or not _precedes(squared, j, row, len(row.closest) - 1):
        return False
    if is_known(known, first, second):
        return False
    for k in range(len(row.closest)):
        if row.closest[k] == j:
            return False
    k = len(row.closest) - 1
    while k > 0 and _precedes(squared, j, row, k - 1):
        row.closest[k], row.squared[k] = row.closest[k - 1], row.squared[k - 1]
        k -= 1
    row.closest[k], row.squared[k] = j, squared
    return True


@inlined
def _precedes(squared: float, j: int, row: Lists, k: int) -> bool:
    """Whether a segment comes before the k-th of the list: closer, or as close and of lower number."""
    return squared < row.squared[k] or (squared == row.squared[k] and j < row.closest[k])
