"""Small bodies of springs."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.elastic.elastic_values import Shell, Solid
from hairpipe.graphs.experiments.elastic.sparsity import multiply


@pytest.fixture
def block():
    """A box of 2 x 2 x 2 m cut into tetrahedra around its diagonals, six to a cube."""
    axis = np.arange(3.0)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=3).reshape(-1, 3)
    cubes = [(i, j, k) for i in range(2) for j in range(2) for k in range(2)]
    paths = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]
    fours = []
    for cube in cubes:
        for path in paths:
            corner, four = np.array(cube), []
            for step in (None, *path):
                corner = corner + (np.eye(3, dtype=int)[step] if step is not None else 0)
                four.append(corner @ [9, 3, 1])
            a, b, c, d = four
            fours.append((a, b, c, d) if path in paths[:3] else (a, b, d, c))
    return Solid(points, np.array(fours, np.int32))


def hexagons(columns=24, rows=24, edge=0.05):
    """A flat sheet of equilateral triangles."""
    i, j = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1), indexing="ij")
    x, z = (i + 0.5 * (j % 2)) * edge, j * edge * np.sqrt(3) / 2
    points = np.stack([x, np.zeros_like(x), z], axis=2).reshape(-1, 3)
    at = i * (rows + 1) + j
    a, b = at[:-1, :-1], at[1:, :-1]
    c, d = at[:-1, 1:], at[1:, 1:]
    odd = (j[:-1, :-1] % 2 == 1)[:, :, None]
    first = np.where(odd, np.stack([a, c, d], 2), np.stack([a, c, b], 2))
    second = np.where(odd, np.stack([a, d, b], 2), np.stack([b, c, d], 2))
    triangles = np.concatenate([first.reshape(-1, 3), second.reshape(-1, 3)]).astype(np.int32)
    return Shell(points, triangles, np.zeros(len(points), bool))


def dense(A, pattern):
    """The matrix of blocks as numpy has it."""
    count = len(pattern.first) - 1
    full = np.zeros((3 * count, 3 * count))
    for i, unit in enumerate(np.eye(3 * count)):
        column = np.empty((count, 3))
        multiply(column, pattern.first, pattern.column, A, unit.reshape(-1, 3))
        full[:, i] = column.ravel()
    return full
