"""Polygon meshes: triangulation, by fans of convex polygons and ear clipping of others; several as one."""

import warnings
from collections.abc import Iterable, Sequence

import numpy as np

from hairpipe.values import Mesh


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
            concave = ~_is_convex(polygons)
            local[concave] = cut_ears(polygons[concave])
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


def cut_ears(polygons: np.ndarray) -> np.ndarray:
    """Return the triangles of simple polygons of one size (p, size, 3), clipping ears, (p, size - 2, 3) int64. Pure.

    A polygon that crosses itself may have no ears: then the most convex corner is clipped.
    """
    count, size = polygons.shape[:2]
    flat = _flatten(polygons)
    left = np.tile(np.arange(size), (count, 1))
    triangles = np.empty((count, size - 2, 3), np.int64)
    for place, number in enumerate(range(size, 3, -1)):
        ears = _find_ears(flat)[:, None]
        triangles[:, place] = np.take_along_axis(left, (ears + np.arange(-1, 2)) % number, axis=1)
        kept = np.arange(number) != ears
        left = left[kept].reshape(count, number - 1)
        flat = flat[kept].reshape(count, number - 1, 2)
    triangles[:, -1] = left
    return triangles


def _flatten(polygons: np.ndarray) -> np.ndarray:
    """Project polygons along the axis nearest to the normal of each, counter-clockwise, (p, size, 2)."""
    normals = newell_normal(polygons)
    axes = np.abs(normals).argmax(axis=1)[:, None]
    is_seen_from_behind = np.take_along_axis(normals, axes, axis=1) < 0.0
    columns = (axes + np.where(is_seen_from_behind, (2, 1), (1, 2))) % 3
    return np.take_along_axis(polygons, columns[:, None], axis=2)


def _find_ears(flat: np.ndarray) -> np.ndarray:
    """Return the first convex corner whose triangle has no other corner, or else the most convex one, (p,)."""
    number = flat.shape[1]
    turns = _areas(np.roll(flat, 1, axis=1), flat, np.roll(flat, -1, axis=1))
    found = turns.argmax(axis=1)
    pending = np.arange(len(flat))
    for ear in range(number):
        tried = pending[turns[pending, ear] > 0.0]
        ordered = flat[tried[:, None], (np.arange(number) + ear - 1) % number]
        a, b, c = (ordered[:, [k]] for k in range(3))
        others = ordered[:, 3:]
        is_inside = np.all([_areas(p, q, others) >= 0.0 for p, q in ((a, b), (b, c), (c, a))], axis=0)
        ended = tried[~is_inside.any(axis=1)]
        found[ended] = ear
        pending = np.setdiff1d(pending, ended, assume_unique=True)
        if not len(pending):
            break
    return found


def _areas(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return twice the areas of triangles in a plane, (..., 2) each, positive where counter-clockwise, (...,)."""
    ab, ac = b - a, c - a
    return ab[..., 0] * ac[..., 1] - ac[..., 0] * ab[..., 1]


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
