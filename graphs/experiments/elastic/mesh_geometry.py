"""Volumes, heights and angles of particles in fours, in numpy."""

import numpy as np

from hairpipe.strands.lattice import altitude_vectors, area_vectors


def volumes(points: np.ndarray, tetrahedra: np.ndarray) -> np.ndarray:
    """Signed volumes [m^3], (t,)."""
    return area_vectors(points[tetrahedra])[1] / 6


LONGEST = 4.0
"""Of the seven altitudes of a tetrahedron over the shortest: of two edges that are parallel none has a length."""


def altitudes(points: np.ndarray, fours: np.ndarray) -> np.ndarray:
    """Signed lengths of the seven altitudes [m], (t, 7), as in `laws/altitude.py`, none too long."""
    areas, volume = area_vectors(points[fours])
    sizes = np.linalg.norm(altitude_vectors(areas), axis=2)
    return volume[:, None] / np.maximum(sizes, sizes.max(axis=1, keepdims=True) / LONGEST)


def lengths(points: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Distances of pairs of particles [m], (e,)."""
    return np.linalg.norm(points[pairs[:, 1]] - points[pairs[:, 0]], axis=1)


def areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Areas of triangles [m^2], (m,)."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def angles(points: np.ndarray, hinges: np.ndarray) -> np.ndarray:
    """Angle by which the two triangles of a hinge are bent out of one plane, signed [rad], (q,)."""
    a, b, c, d = (points[hinges[:, i]] for i in range(4))
    axis = (b - a) / np.maximum(np.linalg.norm(b - a, axis=1, keepdims=True), 1e-300)
    first, second = np.cross(b - a, c - a), np.cross(d - a, b - a)
    return np.arctan2(np.sum(np.cross(first, second) * axis, axis=1), np.sum(first * second, axis=1))
