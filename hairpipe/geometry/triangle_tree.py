"""A bounding volume hierarchy over the triangles of a surface, axis-aligned boxes (AABB) in a binary tree, and the
point of the surface closest to a point in space.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import any_lane, bits, either, lane, maximum, minimum, number, select
from hairpipe.geometry.vec3 import Vector, cross, dot, minus, row, scaled
from hairpipe.values import Mesh
from hairpipe.values.triangles import Sites, in_lowest_triangle

LEAF = 4  # triangles at the most in a box at the bottom
# Width of a triangle over its length. A thinner one lies on its neighbours' edges; dividing by its area makes noise.
THINNEST = 1e-6


class Tree(NamedTuple):
    """A complete binary tree: the children of box i are 2 i and 2 i + 1, the root is 1; the last half are the leaves.

    boxes      low and high corner of every box [m], (2 L, 2, 3) float64
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
    boxes = np.zeros((2 * leaves, 2, 3))
    for side, extreme in enumerate((np.minimum, np.maximum)):
        boxes[leaves:, side] = extreme.reduceat(corners.reshape(-1, 3), 3 * starts[:-1])
        first = leaves  # box of a level
        while first > 1:
            children = boxes[first : 2 * first, side].reshape(-1, 2, 3)
            first //= 2
            boxes[first : 2 * first, side] = extreme.reduce(children, axis=1)
    return Tree(boxes, starts, corners, triangles)


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


@inlined
def closest(tree: Tree, p: Vector, reach: float, guess: int) -> tuple[float, int, Vector]:
    """Return the squared distance [m^2] of p to a surface, the closest triangle's place in the tree, and barycentrics.

    reach  squared distance to search [m^2]; where the surface is farther, the answer is that for the guess
    guess  place of a triangle that may be near; the better the guess, the less is searched
    """
    place = int(number(find_closest(tree, (lane(p[0]), lane(p[1]), lane(p[2])), reach, guess)))
    squared, weights = closest_on_triangle(tree.corners, place, p)
    return squared, place, weights


@inlined
def find_closest(tree, p, reach, guess):
    """Return the places of the triangles closest to points that are near each other, as lanes: see `closest`.

    Exact within reach, but for rounding: every box that could contain a nearer point is opened. The last bit of
    `waiting` states whether the sibling of this box is still to be searched, those before it the same of the boxes
    around this one.
    """
    leaves = len(tree.starts) - 1
    # The guess bounds the search from the start: boxes that are farther are never opened.
    best = minimum(squares_to_triangle(tree.corners, guess, p), reach)
    places = select(best < reach, float(guess), float(guess))  # of all points, also of such that are not finite
    box, waiting = 1, 0
    gap = squares_to_box(tree.boxes, 1, p)
    while True:
        if any_lane(gap < best):
            if box < leaves:
                box, waiting = 2 * box, 2 * waiting
                gap = squares_to_box(tree.boxes, box, p)
                other = squares_to_box(tree.boxes, box + 1, p)
                if bits(other < gap) & 1:  # The child nearer to the first point first: it often excludes the other.
                    box, gap, other = box + 1, other, gap
                waiting |= int(any_lane(other < best))  # One bit a level, no stack: numbers of boxes give the path.
                continue
            for t in range(tree.starts[box - leaves], tree.starts[box - leaves + 1]):
                here = squares_to_triangle(tree.corners, t, p)
                places = select(here < best, float(t), places)
                best = minimum(here, best)
        if waiting == 0:
            return places
        while waiting & 1 == 0:  # Up to the last level on which a box next to the path is still to be searched.
            box, waiting = box >> 1, waiting >> 1
        box, waiting = box ^ 1, waiting ^ 1
        gap = squares_to_box(tree.boxes, box, p)


@inlined
def squares_to_box(boxes, i, p):
    """Return the squared distances [m^2] of points to box i, 0 inside it, as lanes."""
    dx = maximum(maximum(boxes[i, 0, 0] - p[0], p[0] - boxes[i, 1, 0]), 0.0)
    dy = maximum(maximum(boxes[i, 0, 1] - p[1], p[1] - boxes[i, 1, 1]), 0.0)
    dz = maximum(maximum(boxes[i, 0, 2] - p[2], p[2] - boxes[i, 1, 2]), 0.0)
    return dx * dx + dy * dy + dz * dz


@inlined
def squares_to_triangle(corners, t, p):
    """Return the squared distances [m^2] of points to triangle t, as lanes, without branches.

    The least of those to its sides, or that to its plane for points between the planes that stand on the sides.
    """
    a, b, c = row(corners[t], 0), row(corners[t], 1), row(corners[t], 2)
    n = cross(minus(b, a), minus(c, a))
    x, beyond_x = _from_side(a, b, n, p)
    y, beyond_y = _from_side(b, c, n, p)
    z, beyond_z = _from_side(c, a, n, p)
    height = dot(n, minus(p, a))
    beyond = either(either(beyond_x, beyond_y), beyond_z)
    return select(beyond, minimum(minimum(x, y), z), height * height * (1.0 / dot(n, n)))


@inlined
def _from_side(a, b, n, p):
    """Return squared distances of points to a side, and which are beyond the plane that stands on it, along n."""
    side, x = minus(b, a), minus(p, a)
    along = minimum(maximum(dot(side, x) * (1.0 / dot(side, side)), 0.0), 1.0)
    off = minus(x, scaled(along, side))
    return dot(off, off), dot(cross(side, n), x) > 0.0


@inlined
def closest_on_triangle(corners: np.ndarray, t: int, p: Vector) -> tuple[float, Vector]:
    """Return the squared distance [m^2] of p to triangle t, and the barycentrics of the closest point.

    corners  of all triangles [m], (k, 3, 3) float64; none a sliver

    Regions of corner, side and face after Ericson, Real-Time Collision Detection (2005), 5.1.5. On a side the
    barycentric of the corner opposite is exactly 0.
    """
    a = row(corners[t], 0)
    x = minus(p, a)
    u = minus(row(corners[t], 1), a)
    v = minus(row(corners[t], 2), a)
    uu, uv, vv = dot(u, u), dot(u, v), dot(v, v)
    d1, d2 = dot(u, x), dot(v, x)
    d3, d4, d5, d6 = d1 - uu, d2 - uv, d1 - uv, d2 - vv
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        q, s, r = 1.0, 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        q, s, r = 0.0, 1.0, 0.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        q = 1.0 - d1 / uu
        s = d1 / uu
        r = 0.0
    elif d6 >= 0.0 and d5 <= d6:
        q, s, r = 0.0, 0.0, 1.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        q = 1.0 - d2 / vv
        s = 0.0
        r = d2 / vv
    elif va <= 0.0 and d4 >= d3 and d5 >= d6:
        r = min((d4 - d3) / (uu - 2.0 * uv + vv), 1.0)  # Rounding must not make s negative.
        q = 0.0
        s = 1.0 - r
    else:
        q, s, r = va / (va + vb + vc), vb / (va + vb + vc), vc / (va + vb + vc)
    off = minus(minus(x, scaled(s, u)), scaled(r, v))
    return dot(off, off), (q, s, r)


def project(tree: Tree, points: np.ndarray) -> tuple[Sites, np.ndarray]:
    """Return the sites of a surface closest to points [m], (k, 3), and how far they are [m], (k,)."""
    k = len(points)
    sites = Sites(np.empty(k, np.int32), np.empty((k, 3)))
    distances = np.empty(k)
    _find_sites(tree, np.ascontiguousarray(points, dtype=np.float64), *sites, distances)
    return sites, distances


@njit(cache=True, parallel=True)
def _find_sites(tree, points, triangles, barycentrics, distances):
    for i in prange(len(points)):
        squared, place, weights = closest(tree, row(points, i), np.inf, 0)
        triangles[i] = tree.triangles[place]
        distances[i] = np.sqrt(squared)
        for k in range(3):
            barycentrics[i, k] = weights[k]


def nearest_sites(mesh: Mesh, points: np.ndarray) -> tuple[Sites, np.ndarray]:
    """Return the sites of a mesh closest to points [m], (k, 3), and their distances [m], (k,)."""
    sites, distances = project(tree_over(mesh.points[mesh.triangles]), points)
    return in_lowest_triangle(mesh, sites), distances
