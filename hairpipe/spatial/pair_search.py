"""Pairs of segments in trees that are near each other, or may come near in a step."""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import bits, lowest, sqrt
from hairpipe.spatial.pair_collection import CHUNK, gather_pairs, note
from hairpipe.spatial.pairs import Known
from hairpipe.spatial.segment_distance_simd import (
    MOVING,
    blur_of,
    farthest,
    fastest_squared,
    kept_apart,
    length_squared,
    shortest_ways,
)
from hairpipe.spatial.segment_tree import LANES, MOST_OPEN, SINGLE, Tree, box_of, find_leaves, overlapping


def search(few: Tree, many: Tree, known: Known) -> np.ndarray:
    """List pairs of segments, of one tree and of another or of the same, that may be within reach, (n, 2) int32; pure.

    Trees of one frame and reach. First < second; the two share no point and are not known. None is missed.
    """

    def find(*out: np.ndarray) -> None:
        _search(few, many, few is many, known, *out)

    return gather_pairs(find, len(few.segments))


@njit(cache=True, parallel=True)
def _search(few, many, same, known, chunks, begins, found, counts, ends):
    for k in prange(len(chunks)):
        room, near = np.empty(len(many.rows) + MOST_OPEN, np.int64), np.empty(LANES, np.int64)
        first = np.int64(chunks[k]) * CHUNK
        last, count = min(first + CHUNK, len(few.segments)), 0
        piece = first + begins[k]
        while piece < last:
            more = _search_leaf(few, many, same, known, piece // LANES, room, near, found[k], count)
            if more > found.shape[1]:
                break
            count, piece = more, piece + LANES
        counts[k], ends[k] = count, piece - first if piece < last else CHUNK


@inlined
def _search_leaf(few, many, same, known, leaf, room, near, found, count):
    """Write what a leaf may meet, in the same tree at it or after it, to found behind `count` others; count on."""
    for k in range(find_leaves(many, few.boxes, box_of(few, leaf), leaf if same else 0, room)):
        _compare(few, leaf, many, room[k], same and leaf == room[k], near)
        for lane in range(LANES):
            i = few.segments[leaf * LANES + lane]
            while near[lane] != 0:
                j = many.segments[room[k] * LANES + lowest(near[lane])]
                near[lane] &= near[lane] - 1
                count += note(i, j, known, found, count)
    return count


@inlined
def _compare(few, leaf, many, other, same, near):
    """Find which segments of one leaf may get within reach of those of another: for each of these the bits of those.

    Of one leaf and itself those behind each. What is found is looked at later, so that comparisons need not wait.
    """
    near[:] = 0
    mine = overlapping(few.boxes, leaf, many.boxes, box_of(many, other))
    while mine != 0:
        lane = lowest(mine)
        mine &= mine - 1
        overlaps = overlapping(many.boxes, other, few.boxes, (leaf, lane))
        if same:
            overlaps &= -2 << lane
        if overlaps != 0:
            near[lane] = overlaps & _reached(many.rows, other, few.rows, leaf, lane, many.reach)


@inlined
def _reached(rows, leaf, few, mine, lane, reach):
    """Return which segments of a leaf may get within reach of one, a bit for each.

    They come nearer than at half time by no more than the largest displacement of their ends relative to each other.
    Most that move so far slide past each other: a plane keeps them apart.
    """
    way = shortest_ways(rows, leaf, few, mine, lane)
    squared = length_squared(*way)
    reach = SINGLE(reach + blur_of(few, mine, lane))
    if few.shape[1] == MOVING:
        gain = sqrt(fastest_squared(rows, leaf, few, mine, lane)) * SINGLE(1.0 + 1e-5)
        near = bits(squared <= farthest(rows, leaf, few, mine, lane, gain + reach))
        if near != 0:
            near &= ~bits(kept_apart(rows, leaf, few, mine, lane, way, reach, gain))
        return near
    return bits(squared <= farthest(rows, leaf, few, mine, lane, reach))
