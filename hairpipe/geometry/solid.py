"""The inside and the outside of a mesh.

The angle-weighted normal of the closest face, edge or vertex decides the side: Baerentzen and Aanaes, Signed distance
computation using the angle weighted pseudonormal, 2005.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.geometry.triangle_tree import Tree, closest, tree_over
from hairpipe.geometry.vec3 import Vector, blend, dot, minus, row, scaled
from hairpipe.values import Mesh
from hairpipe.values.triangles import normalized, sum_at_vertices, twin_corners, unit_normals

TOUCH = 1e-9  # closer than that the direction away from the surface is its normal [m]
FACE, EDGES, VERTICES = 0, 1, 4  # features: the face, edges 1..3 opposite to corners 0..2, vertices 4..6


class Solid(NamedTuple):
    """A mesh with queries for the depth of a point inside it."""

    tree: Tree  # over its triangles
    normals: np.ndarray  # outward, of the seven features of each triangle in the tree, (k, 7, 3) float64


def solid_of(mesh: Mesh) -> Solid:
    """Return the solid within a mesh; raise BadInput where none of its triangles has an area."""
    tree = tree_over(mesh.points[mesh.triangles])
    return Solid(tree, feature_normals(mesh)[tree.triangles])


def feature_normals(mesh: Mesh) -> np.ndarray:
    """Return the unit normals of the face, the edges and the vertices of every triangle, (m, 7, 3)."""
    faces = unit_normals(mesh)
    twins = twin_corners(mesh.triangles)
    beyond = np.where((twins >= 0)[..., None], faces[twins // 3], 0.0)
    corners = mesh.points[mesh.triangles]
    ahead = normalized(np.roll(corners, -1, axis=1) - corners)
    back = normalized(np.roll(corners, -2, axis=1) - corners)
    angles = np.arccos(np.clip(np.sum(ahead * back, axis=-1), -1.0, 1.0))
    vertices = normalized(sum_at_vertices(mesh, angles[..., None] * faces[:, None]))[mesh.triangles]
    return np.concatenate((faces[:, None], normalized(faces[:, None] + beyond), vertices), axis=1)


@njit(cache=True)
def feature_at(weights: Vector) -> int:
    """Return the feature of a triangle that has a place with given barycentrics."""
    for k in range(3):
        if weights[k] == 1.0:  # Exact: `closest_on_triangle` writes 0 and 1, not results of arithmetic.
            return VERTICES + k
    for k in range(3):
        if weights[k] == 0.0:
            return EDGES + k
    return FACE


@njit(cache=True)
def distance_and_normal(solid: Solid, p: Vector, guess: int) -> tuple[float, Vector, int]:
    """Return the signed distance of p [m], negative inside, and the outward direction in which it grows.

    The third is the place in the tree of the closest triangle: a good guess of it for points nearby.
    """
    squared, place, weights = closest(solid.tree, p, np.inf, guess)
    normal = row(solid.normals[place], feature_at(weights))
    distance = np.sqrt(squared)
    if distance < TOUCH:
        return 0.0, normal, place
    corners = solid.tree.corners[place]
    off = minus(p, blend(weights, row(corners, 0), row(corners, 1), row(corners, 2)))
    side = 1.0 if dot(off, normal) >= 0.0 else -1.0
    return side * distance, scaled(side / distance, off), place
