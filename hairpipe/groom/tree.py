"""A tree of boxes over the triangles of a mesh, with what tells the inside from the outside."""

from typing import NamedTuple

import numpy as np

from hairpipe.data import Mesh
from hairpipe.errors import BadInput
from hairpipe.groom.surface import area_vectors, normalized, twin_corners, unit_normals

LEAF = 4  # triangles in a box at the bottom of the tree


class Tree(NamedTuple):
    """A mesh, ready to be asked for its closest point.

    corners  of the triangles [m], (m, 3, 3) float64
    normals  outward, of the seven features of each triangle, (m, 7, 3) float64
    order    the triangles with area, in the order of the leaves, (r,) int32
    boxes    lower and upper corner of every box [m], (n, 2, 3) float64; children of box i are 2i, 2i+1; the root is 1
    """

    corners: np.ndarray
    normals: np.ndarray
    order: np.ndarray
    boxes: np.ndarray


def plant(mesh: Mesh) -> Tree:
    """Return the tree of a mesh; raise BadInput where none of its triangles has an area."""
    corners = np.ascontiguousarray(mesh.points[mesh.triangles])
    solid = np.flatnonzero(np.any(area_vectors(mesh) != 0.0, axis=1))
    if len(solid) == 0:
        raise BadInput("the body has no triangle with an area", right="a triangle mesh")
    order = solid[np.argsort(morton_codes(corners[solid].mean(axis=1)), kind="stable")].astype(np.int32)
    return Tree(corners, feature_normals(mesh), order, stack_boxes(corners[order]))


def morton_codes(points: np.ndarray) -> np.ndarray:
    """Return the place of points, (k, 3), along a curve that keeps neighbours together, (k,) uint64."""
    low, high = points.min(axis=0), points.max(axis=0)
    grid = ((points - low) / np.maximum(high - low, np.finfo(float).tiny) * (2**21 - 1)).astype(np.uint64)
    codes = np.zeros(len(points), np.uint64)
    for bit in range(21):
        for axis in range(3):
            codes |= (grid[:, axis] >> np.uint64(bit) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return codes


def stack_boxes(corners: np.ndarray) -> np.ndarray:
    """Return the boxes of LEAF triangles each, (r, 3, 3), and of pairs of boxes up to the root; empty: inside out."""
    leaves = 1 << int(np.ceil(np.log2(np.ceil(len(corners) / LEAF))))
    lower, upper = np.full((leaves * LEAF, 3), np.inf), np.full((leaves * LEAF, 3), -np.inf)
    lower[: len(corners)], upper[: len(corners)] = corners.min(axis=1), corners.max(axis=1)
    level = np.stack((lower.reshape(-1, LEAF, 3).min(axis=1), upper.reshape(-1, LEAF, 3).max(axis=1)), axis=1)
    levels = [level]
    while len(level) > 1:
        pairs = level.reshape(-1, 2, 2, 3)
        level = np.stack((pairs[:, :, 0].min(axis=1), pairs[:, :, 1].max(axis=1)), axis=1)
        levels.append(level)
    return np.concatenate([np.zeros((1, 2, 3)), *reversed(levels)])


def feature_normals(mesh: Mesh) -> np.ndarray:
    """Return the unit normals of the face, the edges and the vertices of every triangle, (m, 7, 3)."""
    faces, twins = unit_normals(mesh), twin_corners(mesh.triangles)
    beyond = np.where((twins >= 0)[..., None], faces[twins // 3], 0.0)
    vertices = vertex_normals(mesh, faces)[mesh.triangles]
    return np.concatenate((faces[:, None], normalized(faces[:, None] + beyond), vertices), axis=1)


def vertex_normals(mesh: Mesh, faces: np.ndarray) -> np.ndarray:
    """Return the unit normals of the vertices, (n, 3): those of the faces around, weighted by the angle they span."""
    corners = mesh.points[mesh.triangles]
    ahead = normalized(np.roll(corners, -1, axis=1) - corners)
    back = normalized(np.roll(corners, -2, axis=1) - corners)
    angles = np.arccos(np.clip(np.sum(ahead * back, axis=-1), -1.0, 1.0))
    normals = np.zeros_like(mesh.points)
    np.add.at(normals, mesh.triangles, angles[..., None] * faces[:, None])
    return normalized(normals)
