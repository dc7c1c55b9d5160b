"""A tree of bounding boxes over triangles."""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.levelset.surface import Surface

LEAF = 4


class Tree(NamedTuple):
    """A complete binary tree: node n has the children 2n + 1 and 2n + 2; its last half are the leaves.

    boxes       low and high corner of every node [m], (2 L - 1, 2, 3) float64
    corners     of the triangles, neighbours beside each other [m], (m, 3, 3) float64
    velocities  of the corners [m/s], (m, 3, 3) float64

    Leaf l of L holds the triangles m l // L to m (l + 1) // L.
    """

    boxes: np.ndarray
    corners: np.ndarray
    velocities: np.ndarray


def tree_over(surface: Surface) -> Tree:
    """Return the tree over the triangles, halved at every node where their middles spread the most; pure."""
    leaves = 1 << max(0, int(np.ceil(np.log2(len(surface.corners) / LEAF))))
    order = halved(surface.corners.mean(axis=1), leaves)
    corners = surface.corners[order]
    return Tree(boxes_over(corners, leaves), corners, surface.velocities[order])


@njit(cache=True)
def halved(middles: np.ndarray, leaves: int) -> np.ndarray:
    """Return the order in which the leaves hold the triangles, (m,) int64; pure."""
    order = np.arange(len(middles))
    width = leaves
    while width > 1:
        for l in range(0, leaves, width):
            first, last = len(order) * l // leaves, len(order) * (l + width) // leaves
            part = order[first:last]
            axis, most = 0, 0.0
            for x in range(3):
                along = middles[part, x]
                if np.ptp(along) > most:
                    axis, most = x, np.ptp(along)
            order[first:last] = part[np.argsort(middles[part, axis], kind="mergesort")]
        width //= 2
    return order


@njit(cache=True)
def boxes_over(corners: np.ndarray, leaves: int) -> np.ndarray:
    """Return the boxes of all nodes, (2 leaves - 1, 2, 3) float64; pure."""
    boxes = np.empty((2 * leaves - 1, 2, 3))
    for l in range(leaves):
        first, last = len(corners) * l // leaves, len(corners) * (l + 1) // leaves
        for x in range(3):
            boxes[leaves - 1 + l, 0, x] = corners[first:last, :, x].min() if last > first else np.inf
            boxes[leaves - 1 + l, 1, x] = corners[first:last, :, x].max() if last > first else -np.inf
    for node in range(leaves - 2, -1, -1):
        boxes[node, 0] = np.minimum(boxes[2 * node + 1, 0], boxes[2 * node + 2, 0])
        boxes[node, 1] = np.maximum(boxes[2 * node + 1, 1], boxes[2 * node + 2, 1])
    return boxes
