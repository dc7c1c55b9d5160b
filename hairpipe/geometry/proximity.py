"""Pairs of segments within a distance of each other, or that may come near in a step, and those that are closest.

Broad phase: chunks of one tree search the other in parallel, each into a buffer of its own. A chunk with a full buffer
continues in the next round, with a larger one, so that hair may be of any density. The pairs of all chunks are
concatenated.
"""

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.segment_distance import (
    MOVING,
    blur_of,
    closest_of,
    farthest,
    fastest_squared,
    kept_apart,
    length_squared,
    shortest_ways,
)
from hairpipe.geometry.segment_tree import (
    LANES,
    MOST_OPEN,
    SINGLE,
    Tree,
    box_of,
    build_tree,
    find_frame,
    find_leaves,
    overlapping,
)
from hairpipe.geometry.segments import (
    Known,
    Pairs,
    all_segments,
    chosen,
    is_known,
    key_of,
    known_pairs,
    measure,
    refuse_lost,
    within,
)
from hairpipe.geometry.simd import bits, lowest, sqrt
from hairpipe.geometry.sorting import places_of, rows_at, sorted_by_bits
from hairpipe.geometry.vec3 import cross, dot, minus, row

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


def near_pairs(
    points: np.ndarray,
    offsets: np.ndarray,
    reach: float,
    ignored: np.ndarray | None = None,
    widths: np.ndarray | None = None,
    *,
    exact: bool = True,
) -> Pairs:
    """List every pair of segments, of one strand too, that share no point and are within reach [m]; pure.

    points   [m], (P, 3) float64
    offsets  strand s owns points offsets[s] : offsets[s + 1], (S + 1,) int32
    ignored  sorted keys of pairs to leave out, see `key_of`, (k,) int64
    widths   of segments: two of widths a and b may be (a + b) / 2 of the reach apart, (P,); None: 1
    exact    whether farther pairs that were found are left out, which takes a copy of all

    Raises LostPoints where a position is not finite.
    """
    refuse_lost(points)
    segments = all_segments(offsets)
    tree = build_tree(points, None, segments, reach, find_frame(points, points, segments), widths)
    found = search(tree, tree, known_pairs(ignored, len(points)))
    pairs = measure(points, in_order(found, len(points)))
    return chosen(pairs, within(pairs, len(points), reach, None, widths)) if exact else pairs


CROSS = (0.3, 0.7)
"""Squares of the sine of the angle: below the first two segments run along each other, above the second they cross: at
33 and 57 degrees. At 18 degrees a coarse knot, whose strand runs along itself, slips through itself."""
FARTHER = 0.01
"""A pair has no share of a contact if it is farther than the nearest one next to it by so much of that distance."""


def approaches(pairs: Pairs, among: np.ndarray, points: np.ndarray) -> tuple[Pairs, np.ndarray]:
    """Return the pairs that have a part of a contact of two lines, and these shares, (m,); pure.

    pairs   in order; among  those that matter, (n,) bool
    points  [m], (P, 3)

    Where a strand runs along another one, most of its segments are near three of the other's. The contacts of two lines
    are one where they cross, at joints too, and one for every segment of the first where they run along each other. So
    consecutive segments near the same one share a contact: the nearest has all of it, and two that are equally near
    half of it each. As lines slide and turn, shares change without a jump. If instead the nearest had all of it always,
    contacts would begin and end under load, and hair that lies on itself would never come to rest.
    """
    shares = np.empty(len(among))
    keep = np.empty(len(among), np.bool_)
    _share(pairs, key_of(pairs.segments), among, points, shares, keep)
    places = places_of(keep)
    return Pairs(*(rows_at(field, places) for field in pairs)), rows_at(shares, places)


_ALONG = 1
_ACROSS = 1 << 32
"""Differences of keys of pairs: from one to that of the next second segment, and of the next first one."""


@njit(cache=True, parallel=True)
def _share(pairs, keys, among, points, shares, keep):
    for k in prange(len(keep)):
        shares[k] = _part(keys, pairs.distances, among, np.int64(k), _ALONG) if among[k] else 0.0
        crossing = crossing_of(points, pairs.segments[k, 0], pairs.segments[k, 1]) if shares[k] > 0.0 else 0.0
        if crossing > 0.0:
            shares[k] *= 1.0 - crossing * (1.0 - _part(keys, pairs.distances, among, np.int64(k), _ACROSS))
        keep[k] = shares[k] > 0.0


@inlined
def _part(keys, distances, among, k, stride):
    """Part of pair k of a contact that it shares with the two pairs before and after it."""
    own = distances[k]
    near = _distance(keys, distances, among, k, -1, stride), _distance(keys, distances, among, k, 1, stride)
    before = _distance(keys, distances, among, k, -2, stride) if near[0] < np.inf else np.inf
    after = _distance(keys, distances, among, k, 2, stride) if near[1] < np.inf else np.inf
    least = min(own, min(min(before, near[0]), min(near[1], after)))
    others = _weight(before, least) + _weight(near[0], least) + _weight(near[1], least) + _weight(after, least)
    return _weight(own, least) / (_weight(own, least) + others)


@inlined
def _distance(keys, distances, among, k, steps, stride):
    key = keys[k] + steps * stride
    place = k + steps if stride == _ALONG else np.searchsorted(keys, key)  # Rows are in order.
    near = 0 <= place < len(keys) and keys[place] == key and among[place]
    return distances[place] if near else np.inf


@inlined
def _weight(distance, least):
    left = max(FARTHER * least + 1e-30 - (distance - least), 0.0)  # Of lines that meet, too, the nearest has a weight.
    return left * left


@inlined
def crossing_of(points, i, j):
    """Return 0 for segments that run along each other and 1 for those that cross, with a smooth step between."""
    u, v = minus(row(points, i + 1), row(points, i)), minus(row(points, j + 1), row(points, j))
    n = cross(u, v)
    least, most = CROSS[0] * dot(u, u) * dot(v, v), CROSS[1] * dot(u, u) * dot(v, v)
    part = min(max((dot(n, n) - least) / (most - least), 0.0), 1.0) if most > least else 0.0
    return part * part * (3.0 - 2.0 * part)


_PARTS = 8
"""Number of parts in which segments are ranked, in parallel."""


def closest_pairs(
    points: np.ndarray, pairs: Pairs, among: np.ndarray, most: int, room: np.ndarray | None = None
) -> Pairs:
    """List pairs of segments that are among each other's closest; pure.

    points  [m], (P, 3) float64
    pairs   in order; among  those that may be chosen, (n,) bool
    most    so many closest of each segment count; of equally close ones those with the lower number
    room    a segment's own limit below `most`; a segment with 0 is ignored, (P,)

    No segment is in more pairs than its limit.
    """
    limits = np.full(len(points), most) if room is None else np.minimum(room, most)
    near = chosen(pairs, _have_room(pairs.segments, among, limits))
    closest = np.empty((len(points), most), np.int32)
    _rank(points, near.segments, near.distances, limits, closest)
    mutual = np.empty(len(near.distances), np.bool_)
    _find_mutual(near.segments, closest, mutual)
    return chosen(near, mutual)


@njit(cache=True, parallel=True)
def _have_room(segments, among, limits):
    """Mark the pairs among some both of whose segments have a place left, (n,) bool."""
    have = np.empty(len(segments), np.bool_)
    for k in prange(len(segments)):
        have[k] = among[k] and limits[segments[k, 0]] > 0 and limits[segments[k, 1]] > 0
    return have


@njit(cache=True, parallel=True)
def _rank(points, segments, distances, limits, closest):
    """List for every segment the pairs in which it is closest to others, as many as its limit, the closest first.

    In lexicographic order pairs with one segment come by the number of the other.
    """
    for part in prange(_PARTS):
        start = len(limits) * part // _PARTS
        end = len(limits) * (part + 1) // _PARTS
        closest[start:end] = -1
        # Every part reads the pairs in order and enters those of its own segments: no two threads write one row.
        for pair in range(np.searchsorted(segments[:, 0], end)):
            for i in (segments[pair, 0], segments[pair, 1]):
                if start <= i < end:
                    _enter(pair, points, segments, distances, closest[i, : limits[i]])


@inlined
def _enter(pair, points, segments, distances, row):
    place = len(row)
    # Insertion behind equals: of pairs that are as close, the first in order stays, whatever the threads.
    while place > 0 and (row[place - 1] < 0 or _is_closer(pair, row[place - 1], points, segments, distances)):
        if place < len(row):
            row[place] = row[place - 1]
        place -= 1
    if place < len(row):
        row[place] = pair


@inlined
def _is_closer(pair, other, points, segments, distances):
    if distances[pair] != distances[other]:
        return distances[pair] < distances[other]
    # Squares may differ where their roots are the same.
    squared = closest_of(points, segments[pair, 0], segments[pair, 1])[2]
    return squared < closest_of(points, segments[other, 0], segments[other, 1])[2]


@njit(cache=True, parallel=True)
def _find_mutual(segments, closest, mutual):
    """Mark the pairs that both of their segments list."""
    for pair in prange(len(segments)):
        listed = 0
        for end in range(2):
            for k in range(closest.shape[1]):
                listed += closest[segments[pair, end], k] == pair
        mutual[pair] = listed == 2
