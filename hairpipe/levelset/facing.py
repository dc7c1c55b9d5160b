"""Triangles turned to face outward, whatever their winding was."""

import warnings
from dataclasses import replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hairpipe.geometry.triangles import area_vectors, normalized
from hairpipe.levelset.closed_surface import capped, edge_uses, holes
from hairpipe.levelset.grid_layout import lattice_around
from hairpipe.levelset.outer_shell import OUTSIDE, marked_samples
from hairpipe.values import Body, Mesh

CELLS = 96.0
"""Samples of the flood along the longest side of the mesh."""
CLEAR = 0.1
"""Share of the area of a part, seen from outside, from which its side is known."""
MOST = 0.9
"""Share of the area of known parts that faces inward from which the file is inside out, as a mirrored one is."""


def turned_outward(body: Body) -> Body:
    """Return the body with all triangles facing outward; warns of how many did not."""
    turned = facing_inward(body.mesh)
    if not turned.any():
        return body
    count = f"{turned.sum():,} of {len(turned):,}"
    warnings.warn(f"{count} triangles of the body face inward: they are turned outward", stacklevel=2)
    return replace(body, mesh=turn(body.mesh, turned))


def turn(mesh: Mesh, turned: np.ndarray) -> Mesh:
    """Return the mesh with the winding of some triangles, (m,) bool, reversed."""
    triangles = np.where(turned[:, None], mesh.triangles[:, [0, 2, 1]], mesh.triangles)
    uv = None if mesh.uv is None else np.where(turned[:, None, None], mesh.uv[:, [0, 2, 1]], mesh.uv)
    return replace(mesh, triangles=triangles, uv=uv)


def facing_inward(mesh: Mesh) -> np.ndarray:
    """Return which triangles face inward, (m,) bool.

    Triangles that share an edge with no third one belong to one part, and face one side of it. The outer side of a part
    bulges, and has more area with the outside of the mesh in front and its inside behind, as a flood from outside finds
    them. Where the two disagree, or the flood finds no such area, as for a sheet or what lies within the body, the part
    faces where most of it does in the file, or away from there if the file as a whole is inside out. One with a single
    side, as a Moebius strip, is left alone.
    """
    points, same = np.unique(mesh.points, axis=0, return_inverse=True)  # joined along the seams of textures
    merged = Mesh(points, same.reshape(-1)[mesh.triangles].astype(np.int32))
    vectors = area_vectors(merged)
    areas = np.linalg.norm(vectors, axis=1)
    count = len(areas)
    sides = two_sides(merged.triangles)
    own, other = sides[:count], sides[count:]

    def on_sides(values: np.ndarray) -> np.ndarray:
        """Sum values of triangles, which are opposite on the other side, over the side of each."""
        return (np.bincount(own, values, 2 * count) - np.bincount(other, values, 2 * count))[own]

    facing = np.bincount(own, areas, 2 * count)
    front = facing[own]
    whole = front + facing[other]
    seen = on_sides(areas * seen_sides(merged, normalized(vectors)))
    parts = np.minimum(own, other)
    middles = merged.points[merged.triangles].mean(axis=1)
    sums = [np.bincount(parts, areas * middles[:, axis], 2 * count) for axis in range(3)]
    total = np.maximum(np.bincount(parts, areas, 2 * count), np.finfo(float).tiny)
    centres = np.stack(sums, axis=1) / total[:, None]
    bulge = on_sides(np.einsum("tx,tx->t", middles - centres[parts], vectors) / 3.0)  # volumes of cones to the middle
    sure = (np.abs(seen) > CLEAR * whole) & (np.sign(seen) == np.sign(bulge))
    fewer = np.where(2.0 * front == whole, own > other, 2.0 * front < whole)
    inside_out = areas[sure & (seen < 0.0)].sum() > MOST * areas[sure].sum()
    return (own != other) & np.where(sure, seen < 0.0, fewer ^ inside_out)


def two_sides(triangles: np.ndarray) -> np.ndarray:
    """Number the sides of parts, (2 m,) int32: those of triangles (m, 3) as they are, then of reversed ones."""
    corners = triangles.astype(np.int64)  # products of two vertex numbers do not fit into 32 bits
    tails = corners.ravel()
    heads = np.roll(corners, -1, axis=1).ravel()
    edges = np.minimum(tails, heads) * (corners.max() + 1) + np.maximum(tails, heads)
    order = np.argsort(edges, kind="stable")
    starts = np.flatnonzero(np.diff(edges[order], prepend=-1))
    pairs = starts[np.diff(starts, append=len(order)) == 2]
    first = order[pairs]
    second = order[pairs + 1]
    alike = (tails[first] == heads[second]) & (tails[first] != heads[first])
    count = len(corners)
    a, b = first // 3, second // 3
    rows = np.concatenate([a, a + count])
    columns = np.concatenate([np.where(alike, b, b + count), np.where(alike, b + count, b)])
    links = coo_array((np.ones(len(rows), bool), (rows, columns)), (2 * count, 2 * count))
    return connected_components(links, directed=False)[1]


def seen_sides(mesh: Mesh, normals: np.ndarray) -> np.ndarray:
    """Return 1 where only the front of a triangle is outside, -1 where only its back is, else 0, (m,) int."""
    middles = mesh.points[mesh.triangles].mean(axis=1)
    voxel = float(np.ptp(mesh.points, axis=0).max()) / CELLS
    if voxel == 0.0:
        return np.zeros(len(middles), np.int64)
    edges, uses = edge_uses(mesh.triangles)
    whole = capped(mesh, holes(edges[uses % 2 == 1], mesh.points))
    lattice = lattice_around(whole.points[whole.triangles], voxel, 2.0)
    marks = marked_samples(whole.points[whole.triangles], lattice)

    def outside(places: np.ndarray) -> np.ndarray:
        i, j, k = np.rint(places / voxel - lattice.first).astype(np.int64).T
        return (marks[i, j, k] & OUTSIDE) > 0

    return outside(middles + voxel * normals).astype(np.int64) - outside(middles - voxel * normals)
