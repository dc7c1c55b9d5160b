"""Writhe of a curve."""

import numpy as np


def writhe(points: np.ndarray) -> float:
    """Return the writhe of a polyline, (n, 3): close to the number of its loops, right-handed ones positive.

    Gauss' integral Wr = 1/(4 pi) int int (x' - y') . (dx' x dy') / |x' - y'|^3 over all pairs, exactly for every pair
    of segments (Klenin and Langowski 2000, method 1a). An open curve has a writhe that depends on where it ends.
    """
    first, second = np.triu_indices(len(points) - 1, 2)
    a = points[first]
    b = points[first + 1]
    c = points[second]
    d = points[second + 1]
    normals = [crossed(c - a, d - a), crossed(d - a, d - b), crossed(d - b, c - b), crossed(c - b, c - a)]
    angles = sum(np.arcsin(np.clip(dot(normals[k], normals[k - 3]), -1.0, 1.0)) for k in range(4))
    signs = np.sign(dot(np.cross(d - c, b - a), c - a))
    return float(np.sum(angles * signs) / (2.0 * np.pi))


def crossed(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the unit vectors normal to two others, (n, 3); zero where these are parallel."""
    normal = np.cross(a, b)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.divide(normal, length, out=np.zeros_like(normal), where=length > 0.0)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the products of rows, (n,)."""
    return np.einsum("ij,ij->i", a, b)
