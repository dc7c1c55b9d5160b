"""A bounding volume hierarchy over segments: axis-aligned boxes (AABB), sixteen children to a node.

Segments are sorted along a Morton curve, and sixteen consecutive ones share a leaf. A group is what a box bounds:
sixteen segments, or sixteen boxes, whose sides are adjacent in memory and are compared in one instruction.

Segments that move linearly through a step have a box for its start and one for its end. If two boxes are apart along an
axis at the start, and in the same order at the end, their segments are apart throughout: the gap between what they
bound is concave in time. Motion that neighbours have in common therefore costs nothing.

Numbers are in single precision, in units of a common segment length, from a point amid the hair. Boxes are rounded
outwards; the rounding of distances is bounded (`segment_distance.py`).
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.segment_distance import MOVING, RESTING, ULP, enter_drift, enter_segment
from hairpipe.geometry.segments import TOUCHING
from hairpipe.geometry.simd import bits, both, either, load, lowest, width
from hairpipe.geometry.sorting import morton_order_in_cube
from hairpipe.geometry.vec3 import Vector, length, minus, mix, row, scaled

SINGLE = np.float32
LANES = width(SINGLE)
ALL = (1 << LANES) - 1
MOST_OPEN = 16 * LANES
"""Largest number of groups on the stack of a search: fifteen of each level, and one."""
_SIDES = 6
"""Rows of boxes at one time: least x y z, greatest x y z."""
_SHORTEST = 1e-6
"""Least unit of length [m]: the farthest squares are finite."""
_SAMPLE = 1024


class Frame(NamedTuple):
    """Frame of reference of coordinates.

    centre  where they are zero [m], (3,)
    unit    of length [m]
    extent  of most of the hair from the centre [m]
    """

    centre: np.ndarray
    unit: float
    extent: float


class Tree(NamedTuple):
    """Segments and boxes around them, in units of a frame. Groups 0 to L are leaves, the last one is the root.

    segments  of the leaves, and zeros behind the last, (16 L,) int32
    rows      of the leaves, see `segment_distance`, (L, RESTING or MOVING, 16) float32
    boxes     of the groups at the start and, if they move, at the end, grown by half the reach and by what
              counts as touching, (G, 6 or 12, 16) float32; where there is none the least is above the greatest
    children  first of the sixteen groups that boxes of a group hold; -1 of a leaf, (G,) int64
    ends      one past the last leaf in each group, (G,) int64
    reach     distance within which pairs of the widest are searched
    """

    segments: np.ndarray
    rows: np.ndarray
    boxes: np.ndarray
    children: np.ndarray
    ends: np.ndarray
    reach: float


def find_frame(before: np.ndarray, after: np.ndarray, segments: np.ndarray) -> Frame:
    """Choose a frame for some segments, (m,) int32, that move between positions [m], (P, 3); pure."""
    some = segments[:: max(1, len(segments) // _SAMPLE)]
    if not len(some):
        return Frame(np.zeros(3), 1.0, 1.0)
    starts, ends = (0.5 * (before[k] + after[k]) for k in (some, some + 1))
    centre = np.median(starts, axis=0)
    # A quantile: single far strands must not make the cells of all others coarse.
    extent = 2.0 * np.quantile(np.abs(starts - centre).max(axis=1), 0.98)
    return Frame(centre, max(float(np.median(np.linalg.norm(ends - starts, axis=1))), _SHORTEST), float(extent))


def build_tree(
    before: np.ndarray,
    after: np.ndarray | None,
    segments: np.ndarray,
    reach: float,
    frame: Frame,
    widths: np.ndarray | None = None,
) -> Tree:
    """Sort segments, (m,) int32, for searches within reach [m]; pure.

    before, after  positions [m], (P, 3) float64; None where nothing moves
    widths         of segments: two of widths a and b are searched within (a + b) / 2 of the reach, (P,); None: 1
    """
    moving = after is not None
    after = before if after is None else after
    counts = [-(-len(segments) // LANES)]
    while len(counts) < 2 or counts[-1] > 1:  # One level above the leaves: searches begin at a group of boxes.
        counts.append(-(-counts[-1] // LANES))
    firsts = np.cumsum([0, *counts])
    order = morton_order_in_cube(_find_middles(before, after, segments), frame.centre, frame.extent)
    rows = np.empty((counts[0], MOVING if moving else RESTING, LANES), SINGLE)
    boxes = np.empty((firsts[-1], 2 * _SIDES if moving else _SIDES, LANES), SINGLE)
    children, ends = np.empty(firsts[-1], np.int64), np.empty(firsts[-1], np.int64)
    inside = np.empty(counts[0] * LANES, np.int32)
    # Of the last leaf, and of the last group of each level, lanes may be left over: they overlap nothing.
    inside[-LANES:] = 0
    rows[-1:] = 0.0
    nowhere = np.where(np.arange(boxes.shape[1]) % _SIDES < 3, np.inf, -np.inf)
    boxes[firsts[1:][np.diff(firsts) > 0] - 1] = nowhere[:, None]
    widths = np.ones(len(before)) if widths is None else widths
    _fill_leaves((before, after), (segments, order), frame, 0.5 * reach * widths, inside, rows, boxes)
    _enclose(boxes, firsts, children, ends)
    return Tree(inside, rows, boxes, children, ends, reach * widths.max(initial=0.0) / frame.unit)


@njit(cache=True, parallel=True)
def _find_middles(before, after, segments):
    middles = np.empty((len(segments), 3))
    for k in prange(len(segments)):
        i = segments[k]
        for x in range(3):
            middles[k, x] = 0.25 * (before[i, x] + before[i + 1, x] + after[i, x] + after[i + 1, x])
    return middles


@njit(cache=True, parallel=True)
def _fill_leaves(motion, listed, frame, margins, inside, rows, boxes):
    before, after = motion
    segments, order = listed
    for leaf in prange(len(rows)):
        for lane in range(min(LANES, len(order) - np.int64(leaf) * LANES)):
            i = segments[order[leaf * LANES + lane]]
            inside[leaf * LANES + lane] = i
            p = _in_frame(before, i, frame)
            q = _in_frame(before, i + 1, frame)
            a = _in_frame(after, i, frame)
            b = _in_frame(after, i + 1, frame)
            around = margins[i] / frame.unit + TOUCHING * max(length(minus(q, p)), length(minus(b, a)))
            _enter_box(boxes, leaf, 0, lane, p, q, around)
            enter_segment(rows, leaf, lane, mix(p, a, 0.5), mix(q, b, 0.5))
            if boxes.shape[1] > _SIDES:
                _enter_box(boxes, leaf, _SIDES, lane, a, b, around)
                enter_drift(rows, leaf, lane, scaled(0.5, minus(a, p)), scaled(0.5, minus(b, q)))


@inlined
def _in_frame(points: np.ndarray, i: int, frame: Frame) -> Vector:
    centre = (frame.centre[0], frame.centre[1], frame.centre[2])
    return scaled(1.0 / frame.unit, minus(row(points, i), centre))


@inlined
def _enter_box(boxes, group, side, lane, p, q, margin):
    """Write the box round a segment from p to q, grown by a margin and rounded outwards."""
    for x in range(3):
        low = min(p[x], q[x]) - margin
        high = max(p[x], q[x]) + margin
        boxes[group, side + x, lane] = low - 2.0 * ULP * abs(low)
        boxes[group, side + 3 + x, lane] = high + 2.0 * ULP * abs(high)


@njit(cache=True, parallel=True)
def _enclose(boxes, firsts, children, ends):
    """Number the leaves, and fill the groups above, level by level, with the boxes round those below, in place."""
    for leaf in prange(firsts[1]):
        children[leaf], ends[leaf] = -1, leaf + 1
    for level in range(1, len(firsts) - 1):  # A box is made of those below it.
        for n in prange(firsts[level + 1] - firsts[level]):
            group = firsts[level] + np.int64(n)
            start = firsts[level - 1] + np.int64(n) * LANES
            children[group] = start
            count = min(LANES, firsts[level] - start)
            for lane in range(count):
                for side in range(boxes.shape[1]):
                    sides = boxes[start + lane, side]
                    boxes[group, side, lane] = sides.min() if side % _SIDES < 3 else sides.max()
            ends[group] = ends[start + count - 1]


@inlined
def box_of(tree: Tree, leaf: int) -> tuple[int, int]:
    """Return the group and the lane of the box round a leaf."""
    return len(tree.rows) + leaf // LANES, leaf % LANES


@inlined
def find_leaves(tree: Tree, boxes: np.ndarray, box: tuple[int, int], first: int, room: np.ndarray) -> int:
    """Write the leaves from number `first` on that may hold what is within reach to room; return how many; in place.

    boxes, box  group and lane of that which is within reach of all that is looked for, as in the same frame
    room        (L + MOST_OPEN,) int64
    """
    count = 0
    stack = len(tree.rows)  # Results grow from the front, the stack lies behind all leaves: the two never meet.
    room[stack] = len(tree.children) - 1
    opened = 1
    while opened > 0:
        opened -= 1
        group = room[stack + opened]
        near = overlapping(tree.boxes, group, boxes, box)
        while near != 0:
            child = tree.children[group] + lowest(near)
            near &= near - 1
            if tree.ends[child] <= first:  # All its leaves come before: they were compared from the other side.
                continue
            if tree.children[child] < 0:
                room[count] = child
                count += 1
            else:
                room[stack + opened] = child
                opened += 1
    return count


@inlined
def overlapping(boxes: np.ndarray, group: int, others: np.ndarray, box: tuple[int, int]) -> int:
    """Return which boxes of a group meet another box, of a group and lane of others, in a step; a bit for each."""
    apart = _apart(boxes, group, others, box, 0)
    apart = either(apart, _apart(boxes, group, others, box, 1))
    apart = either(apart, _apart(boxes, group, others, box, 2))
    return ALL ^ bits(apart)


@inlined
def _apart(boxes, group, others, box, x):
    """Whether boxes are apart along an axis during the step, as lanes."""
    other, lane = box
    end = boxes.shape[1] - _SIDES
    # Apart at both ends, in the same order: a box that passes through another is not apart.
    below = both(
        load(boxes, (group, 3 + x)) < others[other, x, lane],
        load(boxes, (group, end + 3 + x)) < others[other, end + x, lane],
    )
    above = both(
        load(boxes, (group, x)) > others[other, 3 + x, lane],
        load(boxes, (group, end + x)) > others[other, end + 3 + x, lane],
    )
    return either(below, above)
