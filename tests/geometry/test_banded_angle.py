"""The banded solver of rows with an angle against dense linear algebra."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.banded_angle import SIZE, eliminate, forward, substitute
from hairpipe.geometry.simd import WIDTH, load, minimum, store

PLACES = 0, 11, 21, 30


@njit
def _solve(A, b, c, lowest):
    least = load(lowest, (0,)), load(lowest, (0,))
    for p in range(len(A)):
        least = eliminate(A, b, p, len(A), least)
    store(lowest, (0,), minimum(least[0], least[1]))
    substitute(A, b, len(A))
    for p in range(len(A)):
        forward(A, c, p, len(A))
    substitute(A, c, len(A))


def _matrix(rows, rng):
    """A symmetric matrix in which an angle does not reach the second row after it."""
    size = 4 * rows
    matrix = rng.normal(size=(size, size))
    row, angle = np.arange(size) // 4, np.arange(size) % 4 == 3
    after = row[None, :] - row[:, None]
    matrix[(after > 2) | ((after == 2) & angle[None, :])] = 0.0
    matrix = np.triu(matrix)
    return matrix + matrix.T + np.eye(size) * (2 * np.abs(matrix).sum() / rows)


def _pack(matrix):
    rows = len(matrix) // 4
    wide, A = np.pad(matrix, ((0, 0), (0, 12))), np.zeros((rows, SIZE))
    for p in range(rows):
        for j, place in enumerate(PLACES):
            A[p, place : place + 11 - j] = wide[4 * p + j, 4 * p + j : 4 * p + 11]
    return np.repeat(A[:, :, None], WIDTH, axis=2)


@pytest.mark.parametrize("rows", [1, 2, 3, 9])
def test_solutions_agree_with_dense_solves_and_no_pivot_is_negative(rows):
    rng = np.random.default_rng(rows)
    matrix, right = _matrix(rows, rng), rng.normal(size=(2, 4 * rows))
    b, c = (np.repeat(each.reshape(rows, 4, 1), WIDTH, axis=2) for each in right)
    lowest = np.ones((1, WIDTH))
    _solve(_pack(matrix), b, c, lowest)
    for found, each in zip((b, c), right, strict=True):
        np.testing.assert_allclose(found[:, :, 3].reshape(-1), np.linalg.solve(matrix, each), rtol=1e-11, atol=1e-13)
    assert lowest.min() > 0.0


def test_lowest_pivot_detects_indefinite_matrices():
    matrix = _matrix(5, np.random.default_rng(1))
    matrix[9, 9] = -1.0
    b, lowest = np.ones((5, 4, WIDTH)), np.ones((1, WIDTH))
    _solve(_pack(matrix), b, b.copy(), lowest)
    assert lowest.max() < 0.0 and np.isfinite(b).all()
