"""Places on a triangle mesh, its normals, and which triangle lies across each edge."""

from typing import NamedTuple

import numpy as np

from hairpipe.values import Mesh

NEAR = 1e-6  # smallest barycentric of a place that is not on an edge


class Sites(NamedTuple):
    """Points on the surface of a mesh.

    triangles     the triangle each lies in, (k,) int32
    barycentrics  where in it, (k, 3) float64, rows sum to 1
    """

    triangles: np.ndarray
    barycentrics: np.ndarray


def site_points(mesh: Mesh, sites: Sites) -> np.ndarray:
    """Return the positions of sites on a mesh [m], (k, 3) float64."""
    return blend_corners(mesh.points[mesh.triangles[sites.triangles]], sites)


def in_lowest_triangle(mesh: Mesh, sites: Sites) -> Sites:
    """Return sites with those on an edge or at a vertex in the lowest of the triangles that meet there; pure.

    Rounding errors decide which of them is the closest, but their frames differ.
    """
    near = sites.barycentrics < NEAR
    triangles = sites.triangles.copy()
    weights = np.where(near, 0.0, sites.barycentrics)
    weights /= weights.sum(axis=1, keepdims=True)
    on_edge = np.flatnonzero(near.sum(axis=1) == 1)
    corner = np.argmax(near, axis=1)
    twins = twin_corners(mesh.triangles)[triangles[on_edge], corner[on_edge]]
    lower = (twins >= 0) & (twins // 3 < triangles[on_edge])
    moved = on_edge[lower]
    k = corner[on_edge[lower]]
    t, j = np.divmod(twins[lower], 3)
    ends = weights[moved, (k + 2) % 3], weights[moved, (k + 1) % 3]
    triangles[moved] = t
    weights[moved, j] = 0.0
    weights[moved, (j + 1) % 3], weights[moved, (j + 2) % 3] = ends
    at_vertex = near.sum(axis=1) == 2
    corner = np.argmin(near, axis=1)
    vertices = mesh.triangles[triangles, corner][at_vertex]
    lowest = np.full(len(mesh.points), len(mesh.triangles), np.int32)
    np.minimum.at(lowest, mesh.triangles, np.arange(len(mesh.triangles), dtype=np.int32)[:, None])
    triangles[at_vertex] = lowest[vertices]
    weights[at_vertex] = mesh.triangles[triangles[at_vertex]] == vertices[:, None]
    return Sites(triangles, weights)


def site_uv(mesh: Mesh, sites: Sites) -> np.ndarray:
    """Return the texture coordinates of sites, (k, 2) float32; zero where the mesh has none."""
    if mesh.uv is None:
        return np.zeros((len(sites.triangles), 2), np.float32)
    return blend_corners(mesh.uv[sites.triangles], sites).astype(np.float32)


def blend_corners(corners: np.ndarray, sites: Sites) -> np.ndarray:
    """Return values at sites from those at the three corners of their triangles, (k, 3, ...) to (k, ...)."""
    q, s, r = sites.barycentrics.T.reshape(3, -1, *[1] * (corners.ndim - 2))
    return q * corners[:, 0] + s * corners[:, 1] + r * corners[:, 2]


def area_vectors(mesh: Mesh) -> np.ndarray:
    """Return the outward normal of every triangle times its area [m^2], (m, 3) float64."""
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    return 0.5 * np.cross(b - a, c - a)


def unit_normals(mesh: Mesh) -> np.ndarray:
    """Return the outward unit normal of every triangle, (m, 3) float64; zero for a triangle without area."""
    return normalized(area_vectors(mesh))


def vertex_normals(mesh: Mesh) -> np.ndarray:
    """Return the outward unit normal of every vertex, its triangles weighted by area, (n, 3) float64; zero without."""
    return normalized(sum_at_vertices(mesh, area_vectors(mesh)[:, None]))


def sum_at_vertices(mesh: Mesh, vectors: np.ndarray) -> np.ndarray:
    """Return for every vertex the sum, in order, of vectors at the corners that lie there, (n, 3) float64.

    vectors  at the corners of the triangles, (m, 3, 3), or the same at all three, (m, 1, 3)
    """
    corners = mesh.triangles.ravel()
    count = len(mesh.points)
    flat = np.broadcast_to(vectors, (*mesh.triangles.shape, 3)).reshape(-1, 3)
    return np.stack([np.bincount(corners, flat[:, axis], count) for axis in range(3)], axis=1)


def normalized(vectors: np.ndarray) -> np.ndarray:
    """Return vectors scaled to unit length, (..., 3) float64; a zero vector stays zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, lengths, out=np.zeros(vectors.shape, lengths.dtype), where=lengths > 0)


def twin_corners(triangles: np.ndarray) -> np.ndarray:
    """Return, for the edge opposite to corner k of triangle t, the corner that faces it from the other side.

    Corners are numbered 3 t + k; the answer is (m, 3) int32, with -1 where an edge belongs to one triangle only, to
    more than two, or to two that disagree on which side is outside.
    """
    corners = triangles.astype(np.int64)  # products of two vertex numbers do not fit into 32 bits
    tails = np.roll(corners, -1, axis=1).ravel()
    heads = np.roll(corners, -2, axis=1).ravel()
    stride = corners.max(initial=0) + 1
    keys, wanted = tails * stride + heads, heads * stride + tails
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    first, last = np.searchsorted(ordered, wanted, "left"), np.searchsorted(ordered, wanted, "right")
    own = np.searchsorted(ordered, keys, "right") - np.searchsorted(ordered, keys, "left")
    paired = (last - first == 1) & (own == 1)
    twins = np.full(len(keys), -1, np.int32)
    twins[paired] = order[first[paired]]
    return twins.reshape(-1, 3)
