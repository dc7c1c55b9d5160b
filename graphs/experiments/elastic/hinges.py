"""Edges and hinges of a mesh; a hinge and its shared edge are a tetrahedron: Fig. 5 of Selle, Lentine, Fedkiw 2008."""

import numpy as np

PAIRS = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
"""Edges of a tetrahedron."""


def tetrahedron_edges(tetrahedra: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges, each once, (e, 2), and which of them the six of every tetrahedron are, (t, 6)."""
    return _unique(tetrahedra[:, PAIRS])


def triangle_edges(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges, each once, (e, 2), and which of them the one opposite to every corner is, (m, 3)."""
    return _unique(triangles[:, [[1, 2], [2, 0], [0, 1]]])


def boundary(tetrahedra: np.ndarray) -> np.ndarray:
    """Triangles of one tetrahedron only, counter-clockwise seen from outside, (m, 3) int32."""
    faces = tetrahedra[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]].reshape(-1, 3)
    _, which, count = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True)
    return faces[count[which.ravel()] == 1].astype(np.int32)


def _unique(pairs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    edges, which = np.unique(np.sort(pairs.reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    return edges, which.reshape(pairs.shape[:-1])


def hinges(triangles: np.ndarray) -> np.ndarray:
    """Particles a, b, c, d of every edge a-b between two triangles: one is a, b, c and the other b, a, d; (q, 4)."""
    corner = triangles.ravel()
    start = triangles[:, [1, 2, 0]].ravel()
    end = triangles[:, [2, 0, 1]].ravel()
    forth = np.flatnonzero(start < end)
    back = np.flatnonzero(start > end)
    size = triangles.max() + 1
    key = end[back] * size + start[back]
    order = np.argsort(key)
    wanted = start[forth] * size + end[forth]
    place = np.minimum(np.searchsorted(key[order], wanted), len(back) - 1)
    shared = key[order][place] == wanted
    there = back[order][place][shared]
    here = forth[shared]
    return np.stack([start[here], end[here], corner[here], corner[there]], axis=1)
