"""Pairs of segments in trees that are near each other, or may come near in a step."""

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined
from hairpipe.sim.contact.distances import MOVING, blur_of, farthest, fastest_squared, squared_distances
from hairpipe.sim.contact.found import CHUNK, gather_pairs, note
from hairpipe.sim.contact.pairs import Known
from hairpipe.sim.contact.tree import LANES, MOST_OPEN, SINGLE, Tree, box_of, find_leaves, overlapping
from hairpipe.sim.lanes import bits, lowest, sqrt


def search(few: Tree, many: Tree, known: Known) -> np.ndarray:
    """List pairs of segments, of one tree and of another or of the same, that may be within reach, (n, 2) int32; pure.

    Trees of one frame and reach. First < second; the two share no point and are not known. None is missed.
    """

    def find(*out: np.ndarray) -> None:
        _search(few, many, few is many, known, *out)

    return gather_pairs(find, len(few.segments))


@njit(cache=True, parallel=True)
def _search(few, many, same, known, chunks, starts, found, counts):  # noqa: ANN001, ANN202
    for k in prange(len(chunks)):
        room = np.empty(len(many.rows) + MOST_OPEN, np.int64)
        counts[k] = _search_chunk(few, many, same, known, np.int64(chunks[k]), room, found[starts[k] : starts[k + 1]])


@inlined
def _search_chunk(few, many, same, known, chunk, room, found):  # noqa: ANN001, ANN202
    """Write what leaves of a chunk may meet, in the same tree at them or after them, to found; count it."""
    count = 0
    leaves = CHUNK // LANES
    for leaf in range(chunk * leaves, min((chunk + 1) * leaves, len(few.rows))):
        for k in range(find_leaves(many, few.boxes, box_of(few, leaf), leaf if same else 0, room)):
            other = room[k]
            mine = overlapping(few.boxes, leaf, many.boxes, box_of(many, other))
            while mine != 0:
                lane = lowest(mine)
                mine &= mine - 1
                near = overlapping(many.boxes, other, few.boxes, (leaf, lane))
                if same and leaf == other:
                    near &= -2 << lane
                if near != 0:
                    near &= _reached(many.rows, other, few.rows, leaf, lane, many.reach)
                i = few.segments[leaf * LANES + lane]
                while near != 0:
                    j = many.segments[other * LANES + lowest(near)]
                    near &= near - 1
                    count += note(i, j, known, found, count)
    return count


@inlined
def _reached(rows, leaf, few, mine, lane, reach):  # noqa: ANN001, ANN202
    """Return which segments of a leaf may get within reach of one, a bit for each.

    They come nearer than at half time by no more than the largest displacement of their ends relative to each other.
    """
    squared = squared_distances(rows, leaf, few, mine, lane)
    reach = SINGLE(reach + blur_of(few, mine, lane))
    if few.shape[1] == MOVING:
        gain = sqrt(fastest_squared(rows, leaf, few, mine, lane)) * SINGLE(1.0 + 1e-5)
        return bits(squared <= farthest(rows, leaf, few, mine, lane, gain + reach))
    return bits(squared <= farthest(rows, leaf, few, mine, lane, reach))
