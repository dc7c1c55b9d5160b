"""Rest shapes of strands that are straighter than their groom: combed, wet, pulled out of a tie."""

import numpy as np

from hairpipe.strands.lattice import transport


def unbent(axis: np.ndarray, normals: np.ndarray, curvature: float) -> np.ndarray:
    """Return strands with a share of the curvature, and the same first segments and lengths [m], (s, n+1, 3); pure.

    Each segment turns from the one before it by that share of its angle, in the same direction in a frame that is
    transported along the strand without twist: a helix keeps its torsion.

    axis       points of strands [m], (s, n+1, 3)
    normals    unit normals of the first segments, (s, 3)
    curvature  share of the turn at every point: 1 returns the axis itself, 0 straight strands
    """
    if curvature == 1.0:
        return axis
    edges = np.diff(axis, axis=1)
    lengths = np.linalg.norm(edges, axis=2, keepdims=True)
    tangents = edges / lengths
    found = np.empty_like(tangents)
    found[:, 0] = now = tangents[:, 0]
    director = turned = normals
    for i in range(1, tangents.shape[1]):
        before = tangents[:, i - 1]
        after = tangents[:, i]
        cosine = np.sum(before * after, axis=1, keepdims=True)
        across = after - cosine * before
        sine = np.linalg.norm(across, axis=1, keepdims=True)
        across /= np.maximum(sine, np.finfo(float).tiny)
        angle = curvature * np.arctan2(sine, cosine)
        aside = np.sum(across * director, axis=1, keepdims=True) * turned
        aside += np.sum(across * np.cross(before, director), axis=1, keepdims=True) * np.cross(now, turned)
        following = np.cos(angle) * now + np.sin(angle) * aside
        following /= np.linalg.norm(following, axis=1, keepdims=True)
        director, turned = transport(director, before, after), transport(turned, now, following)
        found[:, i] = now = following
    return np.concatenate([axis[:, :1], axis[:, :1] + np.cumsum(lengths * found, axis=1)], axis=1)
