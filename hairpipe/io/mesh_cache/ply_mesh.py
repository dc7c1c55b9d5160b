"""Meshes of PLY files (.ply): vertices and polygons."""

import hashlib
from pathlib import Path

import numpy as np

from hairpipe.data import Mesh
from hairpipe.errors import BadInput
from hairpipe.io.mesh_cache.moving import Shape
from hairpipe.io.ply import Columns, Lists, read_ply
from hairpipe.io.polygons import triangulate, warn_of_unused
from hairpipe.io.text import LARGEST

CORNERS = ("vertex_indices", "vertex_index")
KNOWN = ("x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "alpha")


def read_ply_mesh(path: Path, group: str | None = None) -> Shape:
    """Read the triangles of a file; BadInput where it has no polygons, or invalid ones."""
    if group is not None:
        raise BadInput("a PLY file has no groups", where=path, right="no group")
    elements = read_ply(path)
    points = vertices_of(elements, path)
    faces = polygons_of(elements, path)
    warn_of_unused(path, {*elements["vertex"], *elements["face"]} - {*KNOWN, *CORNERS})
    corners = faces.values.astype(np.int64)
    if not len(faces.counts) or faces.counts.min() < 3 or not 0 <= corners.min() <= corners.max() < len(points):
        right = f"polygons of 3 corners or more, of the vertices 0 to {len(points) - 1}"
        raise BadInput("a polygon is invalid", where=f"{path}, element face", right=right)
    triangles = corners[triangulate(points[corners], faces.counts)].astype(np.int32)
    return Shape(Mesh(points, triangles), np.repeat(np.arange(len(faces.counts)), faces.counts - 2))


def read_ply_points(path: Path) -> tuple[np.ndarray, bytes]:
    """Return the vertices of a file, (n, 3) float64, and a digest of its polygons."""
    elements = read_ply(path)
    faces = polygons_of(elements, path)
    parts = (np.asarray(values, np.int64).tobytes() for values in faces)
    return vertices_of(elements, path), hashlib.blake2b(b"".join(parts)).digest()


def vertices_of(elements: dict[str, Columns], path: Path) -> np.ndarray:
    """Return the positions of the vertices, (n, 3) float64; BadInput where they are missing or not finite."""
    columns = [elements.get("vertex", {}).get(name) for name in "xyz"]
    if not all(isinstance(column, np.ndarray) for column in columns):
        raise BadInput("there are no positions", where=path, right="an element vertex with x, y and z")
    points = np.stack([np.asarray(column, np.float64) for column in columns], axis=1)
    bad = ~(np.abs(points) <= LARGEST).all(axis=1)
    if bad.any():
        raise BadInput(f"vertex {bad.argmax()} is not finite", where=path, right="finite numbers")
    return points


def polygons_of(elements: dict[str, Columns], path: Path) -> Lists:
    """Return the corners of the polygons; BadInput where there are none."""
    face = elements.get("face", {})
    found = next((face[name] for name in CORNERS if name in face), None)
    if not isinstance(found, Lists):
        right = f"an element face with a list {' or '.join(CORNERS)}"
        raise BadInput("there are no polygons", where=path, right=right)
    return found
