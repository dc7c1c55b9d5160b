"""Shells of Selle, Lentine, Fedkiw 2008: a noodle, half a hollow torus, of Fig. 4b, and the cloth of Fig. 12."""

import numpy as np

from hairpipe.graphs.experiments.elastic.elastic_values import Shell


def build_noodle(ring: float, tube: float, along: int, around: int, height: float) -> Shell:
    """Make half a hollow torus, open at its two ends, lying on its side.

    ring   radius of the half ring about the Y axis [m]; tube  radius of the tube [m]
    along  quads along the half ring; around  quads around the tube
    height  of the lowest points above the ground [m]
    """
    angle = np.pi * np.arange(along + 1)[:, None] / along
    turn = 2 * np.pi * np.arange(around) / around
    radius = ring + tube * np.cos(turn)
    up = np.broadcast_to(height + tube * (1 + np.sin(turn)), (along + 1, around))
    points = np.stack([radius * np.cos(angle), up, radius * np.sin(angle)], axis=2).reshape(-1, 3)
    triangles = _cut(along, around, np.arange(around), np.roll(np.arange(around), -1), around)
    return Shell(points, triangles, np.zeros(len(points), bool))


def build_cloth(size: float, cells: int, height: float) -> Shell:
    """Make a level square, its two corners at the back pinned.

    size    of an edge [m]; cells  along it; height  above the ground [m]
    """
    x = size * (np.arange(cells + 1) / cells - 0.5)
    points = np.stack([*np.broadcast_arrays(x[None, :], height, x[:, None])], axis=2).reshape(-1, 3)
    triangles = _cut(cells, cells, np.arange(cells), np.arange(1, cells + 1), cells + 1)
    pinned = np.zeros(len(points), bool)
    pinned[[0, cells]] = True
    return Shell(points, triangles, pinned)


def _cut(rows: int, columns: int, left: np.ndarray, right: np.ndarray, stride: int) -> np.ndarray:
    """Cut the quads between `rows` + 1 rows of `stride` points into triangles, diagonals in turn, (m, 3) int32."""
    i, j = (index.ravel() for index in np.indices((rows, columns)))
    a, b = i * stride + left[j], i * stride + right[j]
    c, d = b + stride, a + stride
    even = ((i + j) % 2 == 0)[:, None]
    first = np.where(even, np.stack([a, c, b], 1), np.stack([a, d, b], 1))
    second = np.where(even, np.stack([a, d, c], 1), np.stack([b, d, c], 1))
    return np.concatenate([first, second]).astype(np.int32)
