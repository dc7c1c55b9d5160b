"""Volumes, heights and angles of particles in fours, in numpy."""

import numpy as np


def area_vectors(points: np.ndarray, fours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gradients of six times the volume of fours of particles, and that volume: (t, 4, 3) [m^2] and (t,) [m^3]."""
    a, b, c, d = (points[fours[:, i]] for i in range(4))
    n1, n2, n3 = np.cross(c - a, d - a), np.cross(d - a, b - a), np.cross(b - a, c - a)
    n0 = np.negative(n1 + n2 + n3)
    return np.stack([n0, n1, n2, n3], axis=1), np.sum(n1 * (b - a), axis=1)


def volumes(points: np.ndarray, tetrahedra: np.ndarray) -> np.ndarray:
    """Signed volumes [m^3], (t,)."""
    return area_vectors(points, tetrahedra)[1] / 6


LONGEST = 4.0
"""Of the seven altitudes of a tetrahedron over the shortest: of two edges that are parallel none has a length."""


def altitudes(points: np.ndarray, fours: np.ndarray) -> np.ndarray:
    """Signed lengths of the seven altitudes [m], (t, 7), as in `sim/forces/altitude.py`, none too long."""
    area, volume = area_vectors(points, fours)
    candidates = np.concatenate([area, area[:, [1, 1, 2]] + area[:, [2, 3, 3]]], axis=1)
    sizes = np.linalg.norm(candidates, axis=2)
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
