"""Polygon meshes: triangulation, by fans of convex polygons and ear clipping of others; several as one."""

import warnings
from collections.abc import Iterable, Sequence

import numpy as np

from hairpipe.data import Mesh


def triangulate(corners: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Return the triangles of polygons as indices into their corners, polygon after polygon, (m, 3) int64. Pure.

    corners  positions of all corners, one polygon after another, (c, 3)
    sizes    number of corners of every polygon, 3 or more, (p,)
    """
    starts = np.cumsum(sizes) - sizes
    parts, order = [], []
    for size in np.unique(sizes):
        which = np.flatnonzero(sizes == size)
        polygons = corners[starts[which][:, None] + np.arange(size)]
        fan = np.stack([np.zeros(size - 2), np.arange(1, size - 1), np.arange(2, size)], axis=1).astype(np.int64)
        local = np.tile(fan, (len(which), 1, 1))
        if size > 3:
            for i in np.flatnonzero(~_is_convex(polygons)):
                local[i] = cut_ears(polygons[i])
        parts.append((local + starts[which][:, None, None]).reshape(-1, 3))
        order.append(np.repeat(which, size - 2))
    return np.concatenate(parts)[np.argsort(np.concatenate(order), kind="stable")]


def newell_normal(polygons: np.ndarray) -> np.ndarray:
    """Return the area vectors of polygons (..., size, 3), (..., 3), by Newell's sum of cross products. Pure."""
    around = polygons - polygons[..., :1, :]
    return 0.5 * np.cross(around, np.roll(around, -1, axis=-2)).sum(axis=-2)


def _is_convex(polygons: np.ndarray) -> np.ndarray:
    """Return which polygons, (p, size, 3), are convex, (p,) bool."""
    ahead = np.roll(polygons, -1, axis=1) - polygons
    turns = np.cross(np.roll(ahead, 1, axis=1), ahead)
    return (np.einsum("pij,pj->pi", turns, newell_normal(polygons)) >= 0.0).all(axis=1)


def cut_ears(polygon: np.ndarray) -> np.ndarray:
    """Return the triangles of one simple polygon (size, 3), clipping ears, (size-2, 3). Pure.

    A polygon that crosses itself may have no ears: then the most convex corner is clipped.
    """
    flat = _flatten(polygon)
    left = list(range(len(polygon)))
    triangles = []
    while len(left) > 3:
        turns = [_area(flat[[left[i - 1], left[i], left[(i + 1) % len(left)]]]) for i in range(len(left))]
        ears = [i for i in range(len(left)) if turns[i] > 0.0 and not _holds_any(flat, left, i)]
        ear = ears[0] if ears else int(np.argmax(turns))
        triangles.append([left[ear - 1], left[ear], left[(ear + 1) % len(left)]])
        left.pop(ear)
    return np.array([*triangles, left])


def _flatten(polygon: np.ndarray) -> np.ndarray:
    """Project a polygon along the axis nearest to its normal, counter-clockwise, (size, 2)."""
    normal = newell_normal(polygon)
    axis = int(np.argmax(np.abs(normal)))
    flat = polygon[:, [(axis + 1) % 3, (axis + 2) % 3]]
    return flat if normal[axis] >= 0.0 else flat[:, ::-1]


def _area(triangle: np.ndarray) -> float:
    (ax, ay), (bx, by), (cx, cy) = triangle
    return (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)


def _holds_any(flat: np.ndarray, left: list[int], ear: int) -> bool:
    """Whether the triangle at a corner contains another remaining corner."""
    a, b, c = (flat[left[(ear + step) % len(left)]] for step in (-1, 0, 1))
    others = [left[(ear + step) % len(left)] for step in range(2, len(left) - 1)]
    return any(all(_area(np.array([p, q, flat[o]])) >= 0.0 for p, q in ((a, b), (b, c), (c, a))) for o in others)


def merge_meshes(meshes: Sequence[Mesh]) -> Mesh:
    """Return meshes as one, with texture coordinates 0 on those without any."""
    firsts = np.cumsum([0] + [len(mesh.points) for mesh in meshes])
    triangles = [mesh.triangles + first for mesh, first in zip(meshes, firsts, strict=False)]
    textured = any(mesh.uv is not None for mesh in meshes)
    uv = [np.zeros((len(m.triangles), 3, 2), np.float32) if m.uv is None else m.uv for m in meshes]
    points = np.concatenate([mesh.points for mesh in meshes])
    merged = np.concatenate(triangles).astype(np.int32)
    return Mesh(points, merged, uv=np.concatenate(uv).astype(np.float32) if textured else None)


def warn_of_unused(where: object, names: Iterable[str]) -> None:
    """Name the attributes of a mesh that are not used, if there are any."""
    if unused := sorted(names):
        warnings.warn(f"{where}: attributes that are not used: {', '.join(unused)}", stacklevel=3)
