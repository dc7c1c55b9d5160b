"""Distance of the cage of a subdivision surface, which is what we read, from its limit surface."""

import warnings

import numpy as np

VISIBLE = 1 / 200
"""Largest distance of the limit surface that is not reported, as a share of the size of the mesh."""


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
    """Return the sums of values (m, 3) by row, (count, 3); pure."""
    return np.stack([np.bincount(rows, column, count) for column in values.T], axis=1)
