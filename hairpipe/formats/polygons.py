"""Polygon meshes: triangulation, by fans of convex polygons and ear clipping of others; several as one; cages."""

import warnings
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from hairpipe.values import Mesh

VISIBLE = 1 / 200
"""Largest distance of the limit surface of a cage that is not reported, as a share of the size of the mesh."""


class Polygons(NamedTuple):
    """Triangles of a mesh: those of each polygon follow each other.

    mesh    at one sample [m or file units]
    owners  polygon of every triangle, (m,) int64
    """

    mesh: Mesh
    owners: np.ndarray


def join_polygons(parts: Sequence[Polygons]) -> Polygons:
    """Return the triangles of several meshes as one."""
    firsts = np.cumsum([0] + [part.owners.max(initial=-1) + 1 for part in parts])
    owners = [part.owners + first for part, first in zip(parts, firsts, strict=False)]
    return Polygons(merge_meshes([part.mesh for part in parts]), np.concatenate(owners))


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
            ahead = np.roll(polygons, -1, axis=1) - polygons
            turns = np.cross(np.roll(ahead, 1, axis=1), ahead)
            concave = ~(np.einsum("pij,pj->pi", turns, newell_normal(polygons)) >= 0.0).all(axis=1)
            local[concave] = cut_ears(polygons[concave])
        parts.append((local + starts[which][:, None, None]).reshape(-1, 3))
        order.append(np.repeat(which, size - 2))
    return np.concatenate(parts)[np.argsort(np.concatenate(order), kind="stable")]


def newell_normal(polygons: np.ndarray) -> np.ndarray:
    """Return the area vectors of polygons (..., size, 3), (..., 3), by Newell's sum of cross products. Pure."""
    around = polygons - polygons[..., :1, :]
    return 0.5 * np.cross(around, np.roll(around, -1, axis=-2)).sum(axis=-2)


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


def warn_of_cage(where: str, points: np.ndarray, sizes: np.ndarray, corners: np.ndarray, scheme: str) -> None:
    """Warn where vertices of a cage lie visibly off the limit surface; see `limit_points`.

    Loop's is a scheme of triangles.
    """
    if scheme == "loop" and (sizes != 3).any():
        return
    away = np.linalg.norm(limit_points(points, sizes, corners, scheme) - points, axis=1)
    size = np.ptp(points, axis=0).max(initial=0.0)
    if away.max(initial=0.0) > VISIBLE * size:
        what = f"is a subdivision surface ({scheme}), of which the cage is read"
        off = f"its vertices are up to {100.0 * away.max() / size:.2g} % of the size of the mesh off the surface"
        warnings.warn(f"{where} {what}: {off} (subdivide the mesh before the export, or scheme none)", stacklevel=2)


def limit_points(points: np.ndarray, sizes: np.ndarray, corners: np.ndarray, scheme: str) -> np.ndarray:
    """Return the places of the vertices of a cage on its limit surface, (n, 3) float64; pure.

    Interior vertices by the masks of Catmull-Clark, with one refinement for polygons of any size (Halstead, Kass,
    DeRose 1993), or of Loop; those at a boundary by its cubic B-spline. Creases are not considered.

    points   (n, 3); sizes  corners of each polygon, (p,); corners  vertices of polygons, one after another, (c,)
    scheme   catmullClark or loop
    """
    owners = np.repeat(np.arange(len(sizes)), sizes)
    ends = np.cumsum(sizes) - 1
    ahead = np.arange(1, len(corners) + 1)
    ahead[ends] = ends + 1 - sizes
    pairs = np.stack([corners, corners[ahead]], axis=1)
    edges, edge_of, uses = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True, return_counts=True)
    edge_of = edge_of.reshape(-1)
    centres = _sums(owners, points[corners], len(sizes)) / sizes[:, None]
    valence = np.bincount(edges.ravel(), minlength=len(points))[:, None]
    neighbours = _sums(edges.ravel(), points[edges[:, ::-1].ravel()], len(points))
    n = np.maximum(valence, 1)
    if scheme == "loop":
        beta = (5 / 8 - (3 / 8 + np.cos(2 * np.pi / n) / 4) ** 2) / n
        weight = 1.0 / (n + 3.0 / (8.0 * np.maximum(beta, 1e-12)))
        limit = (1.0 - n * weight) * points + weight * neighbours
    else:
        around = _sums(corners, centres[owners], len(points))
        first = ((n - 3) * points + (points * n + neighbours) / n + around / n) / n
        faces = _sums(edge_of, centres[owners], len(edges))
        middles = (points[edges].sum(axis=1) + faces) / 4.0
        around_limit = 4.0 * _sums(edges.ravel(), np.repeat(middles, 2, axis=0), len(points)) + around
        limit = (n**2 * first + around_limit) / (n * (n + 5))
    rim = np.flatnonzero(uses == 1)
    at_rim = np.bincount(edges[rim].ravel(), minlength=len(points))
    curve = (_sums(edges[rim].ravel(), points[edges[rim][:, ::-1].ravel()], len(points)) + 4.0 * points) / 6.0
    limit = np.where((at_rim == 2)[:, None], curve, limit)
    return np.where(((at_rim != 0) & (at_rim != 2))[:, None] | (valence == 0), points, limit)


def _sums(rows: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    return np.stack([np.bincount(rows, column, count) for column in values.T], axis=1)
