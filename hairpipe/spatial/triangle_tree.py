"""A bounding volume hierarchy over the triangles of a surface: axis-aligned boxes (AABB) in a binary tree."""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.errors import BadInput

LEAF = 4  # triangles at the most in a box at the bottom
# Width of a triangle over its length. A thinner one lies on its neighbours' edges; dividing by its area makes noise.
THINNEST = 1e-6


class Tree(NamedTuple):
    """A complete binary tree: the children of box i are 2 i and 2 i + 1, the root is 1; the last half are the leaves.

    boxes      low and high corner of every box [m], (2 L, 2, 3) float64; an empty one is inside out
    starts     leaf l holds the triangles from starts[l] to starts[l + 1], (L + 1,) int64
    corners    of the triangles, neighbours next to each other [m], (k, 3, 3) float64
    triangles  which of the surface's triangles each of them is, (k,) int32
    """

    boxes: np.ndarray
    starts: np.ndarray
    corners: np.ndarray
    triangles: np.ndarray


def tree_over(corners: np.ndarray) -> Tree:
    """Return the tree over triangles, halved at every box where their middles spread the most; pure.

    corners  of the triangles [m], (m, 3, 3) float64; slivers are left out

    Raises BadInput where no triangle has an area.
    """
    triangles = wide_triangles(corners)
    leaves = 1 << int(np.ceil(np.log2(np.ceil(len(triangles) / LEAF))))
    starts = len(triangles) * np.arange(leaves + 1) // leaves
    triangles = triangles[halved(corners[triangles].mean(axis=1), starts)].astype(np.int32)
    corners = corners[triangles]
    return Tree(boxes_over(corners, starts), starts, corners, triangles)


def wide_triangles(corners: np.ndarray) -> np.ndarray:
    """Return which of the triangles, (m, 3, 3), are wide enough for their length, (k,) int64; BadInput if none is."""
    sides = np.roll(corners, -1, axis=1) - corners
    doubled = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    wide = np.flatnonzero(doubled > THINNEST * (sides**2).sum(axis=2).max(axis=1))
    if len(wide) == 0:
        raise BadInput("no triangle has an area", where="body", right="the mesh of a surface")
    return wide


def halved(middles: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Return the order in which the leaves, none empty, hold triangles with given middles, (k, 3), (k,) int64; pure."""
    order = np.arange(len(middles))
    width = len(starts) - 1
    while width > 1:  # leaves in each of the boxes of a level
        bounds = starts[::width]
        placed = middles[order]
        counts = np.diff(bounds)
        spread = np.maximum.reduceat(placed, bounds[:-1]) - np.minimum.reduceat(placed, bounds[:-1])
        filled = np.arange(counts.max()) < counts[:, None]
        rows = np.full(filled.shape, np.inf)
        rows[filled] = np.take_along_axis(placed, np.repeat(spread.argmax(axis=1), counts)[:, None], axis=1)[:, 0]
        ranks = np.argsort(rows, axis=1, kind="stable") + bounds[:-1, None]  # what fills a row up comes last
        order = order[ranks[filled]]
        width //= 2
    return order


@njit(cache=True)
def boxes_over(corners: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Return the boxes over triangles in the order of the leaves, (2 L, 2, 3) float64; pure."""
    leaves = len(starts) - 1
    boxes = np.empty((2 * leaves, 2, 3))
    boxes[:, 0], boxes[:, 1] = np.inf, -np.inf
    for l in range(leaves):
        for x in range(3):
            for corner in corners[starts[l] : starts[l + 1], :, x].flat:
                boxes[leaves + l, 0, x] = min(boxes[leaves + l, 0, x], corner)
                boxes[leaves + l, 1, x] = max(boxes[leaves + l, 1, x], corner)
    for i in range(leaves - 1, 0, -1):  # Children have higher numbers than their box.
        for x in range(3):
            boxes[i, 0, x] = min(boxes[2 * i, 0, x], boxes[2 * i + 1, 0, x])
            boxes[i, 1, x] = max(boxes[2 * i, 1, x], boxes[2 * i + 1, 1, x])
    return boxes
