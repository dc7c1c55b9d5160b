"""The closest point of a mesh, and on which side of it a point lies.

The side is told by the angle-weighted normal of the face, edge or vertex that is closest: Baerentzen and Aanaes, Signed
distance computation using the angle weighted pseudonormal, 2005.
"""

import numpy as np
from numba import njit, prange

from hairpipe.groom.surface import Sites
from hairpipe.groom.tree import LEAF, Tree
from hairpipe.groom.vectors import Vector, cross, dot, minus, plus, row, times

MOST_WAITING = 64  # boxes put off during a search: one a level of the tree
TOUCH = 1e-9  # closer than that the direction away from the surface is its normal [m]
FACE, EDGES, VERTICES = 0, 1, 4  # features: the face, edges 1..3 opposite to corners 0..2, vertices 4..6


@njit(cache=True)
def box_distance(boxes: np.ndarray, i: int, p: Vector) -> float:
    """Return the squared distance of p to box i [m^2], infinite for an empty one."""
    total = 0.0
    for k in range(3):
        gap = max(boxes[i, 0, k] - p[k], p[k] - boxes[i, 1, k], 0.0)
        total += gap * gap
    return total


@njit(cache=True)
def closest_on_edge(a: Vector, b: Vector, p: Vector) -> tuple[float, float]:
    """Return the fraction of the way from a to b that is closest to p, and its squared distance [m^2]."""
    ab, ap = minus(b, a), minus(p, a)
    squared = dot(ab, ab)
    t = min(max(dot(ab, ap) / squared, 0.0), 1.0) if squared > 0.0 else 0.0
    off = minus(ap, times(t, ab))
    return t, dot(off, off)


@njit(cache=True)
def closest_on_triangle(a: Vector, b: Vector, c: Vector, p: Vector) -> tuple[Vector, int, float]:
    """Return the barycentric coordinates of the point of a triangle closest to p, its feature and squared distance."""
    n = cross(minus(b, a), minus(c, a))
    squared = dot(n, n)
    u = dot(cross(minus(b, p), minus(c, p)), n) / squared
    v = dot(cross(minus(c, p), minus(a, p)), n) / squared
    if u > 0.0 and v > 0.0 and u + v < 1.0:
        height = dot(n, minus(p, a))
        return (u, v, 1.0 - u - v), FACE, height * height / squared
    return closest_on_border(a, b, c, p)


@njit(cache=True)
def closest_on_border(a: Vector, b: Vector, c: Vector, p: Vector) -> tuple[Vector, int, float]:
    """Return the same for the three edges of a triangle alone."""
    t, best = closest_on_edge(b, c, p)
    weights, feature = (0.0, 1.0 - t, t), feature_on_edge(0, t)
    t, squared = closest_on_edge(c, a, p)
    if squared < best:
        weights, feature, best = (t, 0.0, 1.0 - t), feature_on_edge(1, t), squared
    t, squared = closest_on_edge(a, b, p)
    if squared < best:
        weights, feature, best = (1.0 - t, t, 0.0), feature_on_edge(2, t), squared
    return weights, feature, best


@njit(cache=True)
def feature_on_edge(k: int, t: float) -> int:
    """Return the feature at fraction t of the edge opposite to corner k."""
    if t == 0.0:
        return VERTICES + (k + 1) % 3
    return VERTICES + (k + 2) % 3 if t == 1.0 else EDGES + k


@njit(cache=True)
def closest_on(tree: Tree, t: int, p: Vector) -> tuple[Vector, int, float]:
    """Return the same for triangle t."""
    c = tree.corners[t]
    return closest_on_triangle(row(c, 0), row(c, 1), row(c, 2), p)


@njit(cache=True)
def closest(tree: Tree, p: Vector, guess: int) -> tuple[int, Vector, int, float]:
    """Return the triangle closest to p, barycentric coordinates and feature of the point in it, its distance [m].

    The search starts from a guess of the triangle, which shortens it much where it is good.
    """
    stack = np.empty(MOST_WAITING, np.int64)
    stack[0], height = 1, 1
    leaves = len(tree.boxes) // 2
    triangle = guess
    weights, feature, best = closest_on(tree, guess, p)
    while height > 0:
        height -= 1
        node = stack[height]
        if box_distance(tree.boxes, node, p) >= best:
            continue
        if node < leaves:
            near, far = 2 * node, 2 * node + 1
            if box_distance(tree.boxes, far, p) < box_distance(tree.boxes, near, p):
                near, far = far, near
            stack[height], stack[height + 1] = far, near
            height += 2
            continue
        first = (node - leaves) * LEAF
        for t in tree.order[first : first + LEAF]:
            where, kind, squared = closest_on(tree, t, p)
            if squared < best:
                triangle, weights, feature, best = t, where, kind, squared
    return triangle, weights, feature, np.sqrt(best)


@njit(cache=True)
def site_on(tree: Tree, t: int, weights: Vector) -> Vector:
    """Return the position of a place in triangle t [m]."""
    c = tree.corners[t]
    return plus(plus(times(weights[0], row(c, 0)), times(weights[1], row(c, 1))), times(weights[2], row(c, 2)))


@njit(cache=True)
def distance_and_normal(tree: Tree, p: Vector, guess: int) -> tuple[float, Vector, int]:
    """Return the signed distance of p [m], negative inside, the outward direction in which it grows, the triangle."""
    t, weights, feature, d = closest(tree, p, guess)
    normal = row(tree.normals[t], feature)
    off = minus(p, site_on(tree, t, weights))
    if d < TOUCH:
        return 0.0, normal, t
    side = 1.0 if dot(off, normal) >= 0.0 else -1.0
    return side * d, times(side / d, off), t


@njit(cache=True, parallel=True)
def closest_sites(
    tree: Tree, points: np.ndarray, triangles: np.ndarray, barycentrics: np.ndarray, distances: np.ndarray
) -> None:
    """Write the closest site and its distance [m] for every point (k, 3), into (k,), (k, 3) and (k,)."""
    for i in prange(len(points)):
        triangles[i], weights, _, distances[i] = closest(tree, row(points, i), tree.order[0])
        for k in range(3):
            barycentrics[i, k] = weights[k]


def project(tree: Tree, points: np.ndarray) -> tuple[Sites, np.ndarray]:
    """Return the sites of a mesh closest to points [m], (k, 3), and how far they are [m], (k,)."""
    k = len(points)
    sites, distances = Sites(np.empty(k, np.int32), np.empty((k, 3))), np.empty(k)
    closest_sites(tree, np.ascontiguousarray(points, dtype=np.float64), *sites, distances)
    return sites, distances
