"""Pairs of segments within a distance of each other."""

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined
from hairpipe.sim.contact.distances import squared_distances
from hairpipe.sim.contact.found import CHUNK, gather_pairs, in_order, note
from hairpipe.sim.contact.grid import LANES, MOST_RUNS, build_grid, entry, find_runs, reaching, rounding
from hairpipe.sim.contact.pairs import Pairs, known_pairs, measure
from hairpipe.sim.contact.pieces import all_segments, cut_in_pieces, refuse_lost
from hairpipe.sim.lanes import bits, lowest


def near_pairs(points: np.ndarray, offsets: np.ndarray, reach: float, ignored: np.ndarray | None = None) -> Pairs:
    """List every pair of segments, of one strand too, that share no point and are within reach [m]; pure.

    points   [m], (P, 3) float64
    offsets  strand s owns points offsets[s] : offsets[s + 1], (S + 1,) int32
    ignored  sorted keys of pairs to leave out, see `key_of`, (k,) int64

    Raises ArithmeticError where a position is not finite.
    """
    refuse_lost(points)
    grid = build_grid(points, cut_in_pieces(points, all_segments(len(points), offsets), reach), reach)
    known = known_pairs(ignored, len(points))
    found = gather_pairs(lambda *out: _search(grid, reach / grid.cell, known, *out), len(grid.segments))
    pairs = measure(points, in_order(found, len(points)))
    keep = pairs.distances <= reach
    return pairs if keep.all() else Pairs(*(field[keep] for field in pairs))


@njit(cache=True, parallel=True)
def _search(grid, reach, known, chunks, starts, found, counts):  # noqa: ANN001, ANN202
    """Write the pairs that chunks of the grid begin, and maybe some a little farther apart, to found; count them."""
    for k in prange(len(chunks)):
        chunk = np.int64(chunks[k])
        runs = np.empty((MOST_RUNS, 2), np.int64)
        counts[k] = _search_chunk(grid, reach, known, chunk, runs, found[starts[k] : starts[k + 1]])


@inlined
def _search_chunk(grid, reach, known, chunk, runs, found):  # noqa: ANN001, ANN202
    count = 0
    for e in range(chunk * CHUNK, min((chunk + 1) * CHUNK, len(grid.segments))):
        p, d, dd, inverse = entry(grid, e)
        radius = reach + grid.half
        blur, excess = rounding(p, radius, grid.half)
        low, high = reaching(p, d, radius + blur)
        limit = np.float32(((reach + blur) ** 2 + excess) * (1.0 + 1e-6))
        for r in range(find_runs(grid, low, high, e + 1, runs)):
            for start in range(runs[r, 0], runs[r, 1], LANES):
                near = bits(squared_distances(grid.rows, p, d, dd, inverse, start) <= limit)
                near &= (1 << min(runs[r, 1] - start, LANES)) - 1
                while near != 0:
                    other = grid.segments[start + lowest(near)]
                    near &= near - 1
                    count += note(grid.segments[e], other, known, found, count)
    return count
