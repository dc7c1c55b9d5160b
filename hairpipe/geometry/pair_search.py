"""Broad phase: pairs of segments in trees that are or may come near each other in a step.

Chunks of one tree search the other in parallel, each into a buffer of its own. A chunk with a full buffer continues in
the next round, with a larger one, so that hair may be of any density. The pairs of all chunks are concatenated.
"""

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.segment_distance import (
    MOVING,
    blur_of,
    farthest,
    fastest_squared,
    kept_apart,
    length_squared,
    shortest_ways,
)
from hairpipe.geometry.segment_tree import LANES, MOST_OPEN, SINGLE, Tree, box_of, find_leaves, overlapping
from hairpipe.geometry.segments import Known, is_known
from hairpipe.geometry.simd import bits, lowest, sqrt
from hairpipe.geometry.sorting import sorted_by_bits

CHUNK = 1024
"""Segments that one thread searches for at a time."""
_ROOM = 16
"""Size of buffers in the first round, in pairs per segment."""
_GROWTH = 2
"""Growth of buffers per round."""


def search(few: Tree, many: Tree, known: Known) -> np.ndarray:
    """List pairs of segments, of one tree and of another or of the same, that may be within reach, (n, 2) int32; pure.

    Trees of one frame and reach. First < second; the two share no point and are not known. None is missed.
    """
    chunks = np.arange(-(-len(few.segments) // CHUNK))
    room = _ROOM * CHUNK
    rounds = []
    begins, totals = np.zeros_like(chunks), np.zeros_like(chunks)
    while len(chunks):
        found = np.empty((len(chunks), room, 2), np.int32)
        counts = np.zeros_like(chunks)
        ends = np.empty_like(chunks)
        _search(few, many, few is many, known, CHUNK * chunks + begins, found, counts, ends)
        rounds.append((totals[chunks], chunks, found, counts))
        totals[chunks] += counts
        # Only chunks with a full buffer continue, so that most hair is not searched again.
        chunks = chunks[ends < CHUNK]
        begins = ends[ends < CHUNK]
        room = _GROWTH * room
    # Pairs are in the order of chunks: the list does not depend on the buffers.
    starts = np.cumsum(totals) - totals
    pairs = np.empty((totals.sum(), 2), np.int32)
    for before, chunks, found, counts in rounds:
        _collect(found, counts, starts[chunks] + before, pairs)
    return pairs


@njit(cache=True, parallel=True)
def _search(few, many, same, known, begins, found, counts, ends):
    """Search from segments on, (k,), to the ends of their chunks, or of the rows of found, (k, room, 2), in place.

    counts  of the pairs that each found, (k,)
    ends    segment of its chunk from which each goes on in the next round, CHUNK where it is done, (k,)
    """
    for k in prange(len(begins)):
        scratch = np.empty(len(many.rows) + MOST_OPEN, np.int64), np.empty(LANES, np.int64)
        piece = begins[k]
        first = piece // CHUNK * CHUNK
        last = min(first + CHUNK, len(few.segments))
        count = 0
        while piece < last:
            more = _search_leaf((few, many, same, known), piece // LANES, scratch, found[k], count)
            if more > found.shape[1]:
                break  # Pairs of this leaf are not counted yet: the next round searches it again from its beginning.
            count = more
            piece = piece + LANES
        counts[k] = count
        ends[k] = piece - first if piece < last else CHUNK


@inlined
def _search_leaf(trees, leaf, scratch, found, count):
    """Write what a leaf may meet, in the same tree at it or after it, to found behind `count` others; count on."""
    few, many, same, known = trees
    room, near = scratch
    # Within one tree from this leaf on only: each pair of leaves is compared once.
    for k in range(find_leaves(many, few.boxes, box_of(few, leaf), leaf if same else 0, room)):
        _compare(few, leaf, many, room[k], same and leaf == room[k], near)
        for lane in range(LANES):
            i = few.segments[leaf * LANES + lane]
            while near[lane] != 0:
                j = many.segments[room[k] * LANES + lowest(near[lane])]
                near[lane] &= near[lane] - 1  # One turn a candidate, not one for each of the sixteen lanes.
                first = min(i, j)
                second = max(i, j)
                # Neighbours on a strand share a point; across two strands the number between them is no segment.
                if second - first > 1 and not is_known(known, first, second):
                    if count < len(found):
                        found[count, 0] = first
                        found[count, 1] = second
                    count += 1
    return count


@inlined
def _compare(few, leaf, many, other, same, near):
    """Find which segments of one leaf may get within reach of those of another: for each of these the bits of those.

    Of one leaf and itself those behind each. What is found is looked at later, so that comparisons need not wait.
    """
    near[:] = 0
    # Segments of this leaf whose boxes meet the other leaf at all: only these are tested one by one.
    mine = overlapping(few.boxes, leaf, many.boxes, box_of(many, other))
    while mine != 0:
        lane = lowest(mine)
        mine &= mine - 1
        overlaps = overlapping(many.boxes, other, few.boxes, (leaf, lane))
        if same:
            overlaps &= -2 << lane  # Within one leaf, each pair once.
        if overlaps != 0:
            near[lane] = overlaps & _reached(many.rows, other, few.rows, leaf, lane, many.reach)


@inlined
def _reached(rows, leaf, few, mine, lane, reach):
    """Return which segments of a leaf may get within reach of one, a bit for each.

    They come nearer than at half time by no more than the largest displacement of their ends relative to each other.
    Most that move so far slide past each other: a plane keeps them apart.
    """
    way = shortest_ways(rows, leaf, few, mine, lane)
    squared = length_squared(way)
    reach = SINGLE(reach + blur_of(few, mine, lane))
    if few.shape[1] == MOVING:
        gain = sqrt(fastest_squared(rows, leaf, few, mine, lane)) * SINGLE(1.0 + 1e-5)
        near = bits(squared <= farthest(rows, leaf, few, mine, lane, gain + reach))
        if near != 0:
            near &= ~bits(kept_apart(rows, leaf, few, mine, lane, way, reach, gain))
        return near
    return bits(squared <= farthest(rows, leaf, few, mine, lane, reach))


@njit(cache=True, parallel=True)
def _collect(found, counts, starts, pairs):
    for c in prange(len(counts)):
        for k in range(counts[c]):
            pairs[starts[c] + k, 0] = found[c, k, 0]
            pairs[starts[c] + k, 1] = found[c, k, 1]


def in_order(pairs: np.ndarray, points: int) -> np.ndarray:
    """Sort pairs of segments below `points`, (n, 2) int32, lexicographically; pure."""
    keys = np.ascontiguousarray(pairs).view(np.int64)[:, 0]
    for first_bit in (32, 0):  # Processors for which numba compiles are little-endian: the second is in the high bits.
        keys = sorted_by_bits(keys, first_bit, first_bit + int(points).bit_length())
    return keys.view(np.int32).reshape(-1, 2)
