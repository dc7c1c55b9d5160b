"""The point of a surface closest to a point in space."""

import numpy as np

from hairpipe.levelset.inlined import inlined
from hairpipe.levelset.tree import Tree


@inlined
def closest(
    tree: Tree, x: float, y: float, z: float, reach: float, guess: int, nodes: np.ndarray, bounds: np.ndarray
) -> tuple[float, int, float, float]:
    """Return the squared distance [m^2] to the surface, the triangle, and the weights of its second and third corner.

    reach          squared distance to search [m^2]; where the surface is farther, the answer is that for the guess
    guess          a triangle that may be near; the better the guess, the less is searched
    nodes, bounds  room to work in, (64,) int64 and (64,) float64

    Exact within reach: every box is opened that could hold a nearer point.
    """
    found = guess
    squared, s, r = closest_on_triangle(tree.corners, guess, x, y, z)
    best = min(squared, reach)
    boxes = tree.boxes
    leaves = (len(boxes) + 1) // 2
    count = len(tree.corners)
    nodes[0], bounds[0] = 0, 0.0
    top = 1
    while top > 0:
        top -= 1
        if bounds[top] >= best:
            continue
        node = nodes[top]
        if node >= leaves - 1:
            l = node - (leaves - 1)
            for t in range(count * l // leaves, count * (l + 1) // leaves):
                d, ts, tr = closest_on_triangle(tree.corners, t, x, y, z)
                if d < best:
                    found, squared, best, s, r = t, d, d, ts, tr
            continue
        near, far = 2 * node + 1, 2 * node + 2
        to_near, to_far = to_box(boxes, near, x, y, z), to_box(boxes, far, x, y, z)
        if to_far < to_near:
            near, far, to_near, to_far = far, near, to_far, to_near
        nodes[top], bounds[top] = far, to_far
        nodes[top + 1], bounds[top + 1] = near, to_near
        top += 2
    return squared, found, s, r


@inlined
def to_box(boxes: np.ndarray, n: int, x: float, y: float, z: float) -> float:
    """Return the squared distance [m^2] from a point to the box of node n, 0 inside it."""
    dx = max(boxes[n, 0, 0] - x, 0.0, x - boxes[n, 1, 0])
    dy = max(boxes[n, 0, 1] - y, 0.0, y - boxes[n, 1, 1])
    dz = max(boxes[n, 0, 2] - z, 0.0, z - boxes[n, 1, 2])
    return dx * dx + dy * dy + dz * dz


@inlined
def closest_on_triangle(corners: np.ndarray, t: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return the squared distance [m^2] to triangle t and the weights of its second and third corner there.

    corners  of all triangles [m], (m, 3, 3) float64

    Regions of corner, side and face after Ericson, Real-Time Collision Detection (2005), 5.1.5.
    """
    ax, ay, az = x - corners[t, 0, 0], y - corners[t, 0, 1], z - corners[t, 0, 2]
    ux, uy, uz = side(corners, t, 1)
    vx, vy, vz = side(corners, t, 2)
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    d1, d2 = ux * ax + uy * ay + uz * az, vx * ax + vy * ay + vz * az
    d3, d4, d5, d6 = d1 - uu, d2 - uv, d1 - uv, d2 - vv
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        s, r = 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        s, r = 1.0, 0.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        s, r = d1 / uu, 0.0
    elif d6 >= 0.0 and d5 <= d6:
        s, r = 0.0, 1.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        s, r = 0.0, d2 / vv
    elif va <= 0.0 and d4 >= d3 and d5 >= d6:
        r = (d4 - d3) / (uu - 2.0 * uv + vv)
        s = 1.0 - r
    else:
        s, r = vb / (va + vb + vc), vc / (va + vb + vc)
    dx, dy, dz = ax - s * ux - r * vx, ay - s * uy - r * vy, az - s * uz - r * vz
    return dx * dx + dy * dy + dz * dz, s, r


@inlined
def side(corners: np.ndarray, t: int, c: int) -> tuple[float, float, float]:
    """Return the way from the first corner of a triangle to corner c [m]."""
    x, y, z = corners[t, 0, 0], corners[t, 0, 1], corners[t, 0, 2]
    return corners[t, c, 0] - x, corners[t, c, 1] - y, corners[t, c, 2] - z
