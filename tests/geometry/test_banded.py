"""Banded solvers against dense linear algebra."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.banded import OFFSET, eliminate, fix_lanes, row_size, substitute
from hairpipe.geometry.banded_angle import SIZE, forward
from hairpipe.geometry.banded_angle import eliminate as eliminate_rows
from hairpipe.geometry.banded_angle import substitute as substitute_rows
from hairpipe.geometry.simd import WIDTH, load, minimum, store


@njit
def _solve(A, b, reach):
    for p in range(len(A)):
        eliminate(A, b, p, len(A), reach)
    substitute(A, b, len(A), reach)


@njit
def _solve_with_tip_fixed(A, b, fixed, reach):
    for p in range(len(A)):
        if p == len(A) - 1:
            fix_lanes(A, b, p, load(fixed, (0,)) > 0.0)
        eliminate(A, b, p, len(A), reach)
    substitute(A, b, len(A), reach)


def _random_system(particles, reach, rng):
    """A symmetric positive definite matrix of 3 x 3 blocks that reaches so many particles, and a right-hand side."""
    size = 3 * particles
    matrix = rng.normal(size=(size, size))
    block = np.arange(size) // 3
    matrix[np.abs(block[:, None] - block[None, :]) > reach] = 0.0
    matrix = matrix + matrix.T
    return matrix + np.eye(size) * (np.abs(matrix).sum(1).max() + 1), rng.normal(size=size)


def _pack(matrix, A, lane, reach):
    particles = len(A)
    blocks = matrix.reshape(particles, 3, particles, 3).transpose(0, 2, 1, 3)
    for p in range(particles):
        A[p, :OFFSET, lane] = blocks[p, p][np.triu_indices(3)]
        for o in range(1, min(reach, particles - 1 - p) + 1):
            A[p, OFFSET + 9 * (o - 1) : OFFSET + 9 * o, lane] = blocks[p, p + o].reshape(-1)


def _systems(particles, reach):
    """A different system in every lane: A and b, and the dense matrices and right-hand sides."""
    rng = np.random.default_rng(particles)
    A, b = np.zeros((particles, row_size(reach), WIDTH)), np.empty((particles, 3, WIDTH))
    dense = [_random_system(particles, reach, rng) for _ in range(WIDTH)]
    for lane, (matrix, right) in enumerate(dense):
        _pack(matrix, A, lane, reach)
        b[:, :, lane] = right.reshape(-1, 3)
    return A, b, dense


@pytest.mark.parametrize("particles", [1, 2, 3, 4, 9, 30])
@pytest.mark.parametrize("reach", [2, 3])
def test_solution_agrees_with_dense_solve(particles, reach):
    A, b, dense = _systems(particles, reach)
    _solve(A, b, reach)
    expected = [np.linalg.solve(matrix, right).reshape(-1, 3) for matrix, right in dense]
    np.testing.assert_allclose(b, np.stack(expected, axis=2), rtol=1e-11, atol=1e-13)


def test_a_tip_is_fixed_in_the_lanes_of_a_mask_only():
    """There its unknown is zero, and the others are those of the system without it."""
    A, b, dense = _systems(9, 3)
    fixed = np.arange(WIDTH)[None] % 2 * 1.0
    _solve_with_tip_fixed(A, b, fixed, 3)
    for lane, (matrix, right) in enumerate(dense):
        left = 24 if fixed[0, lane] else 27
        expected = np.zeros(27)
        expected[:left] = np.linalg.solve(matrix[:left, :left], right[:left])
        np.testing.assert_allclose(b[:, :, lane].reshape(-1), expected, rtol=1e-11, atol=1e-13)


PLACES = 0, 11, 21, 30


@njit
def _solve_rows(A, b, c, lowest):
    least = load(lowest, (0,)), load(lowest, (0,))
    for p in range(len(A)):
        least = eliminate_rows(A, b, p, len(A), least)
    store(lowest, (0,), minimum(least[0], least[1]))
    substitute_rows(A, b, len(A))
    for p in range(len(A)):
        forward(A, c, p, len(A))
    substitute_rows(A, c, len(A))


def _matrix(rows, rng):
    """A symmetric matrix in which an angle does not reach the second row after it."""
    size = 4 * rows
    matrix = rng.normal(size=(size, size))
    row, angle = np.arange(size) // 4, np.arange(size) % 4 == 3
    after = row[None, :] - row[:, None]
    matrix[(after > 2) | ((after == 2) & angle[None, :])] = 0.0
    matrix = np.triu(matrix)
    return matrix + matrix.T + np.eye(size) * (2 * np.abs(matrix).sum() / rows)


def _pack_rows(matrix):
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
    _solve_rows(_pack_rows(matrix), b, c, lowest)
    for found, each in zip((b, c), right, strict=True):
        np.testing.assert_allclose(found[:, :, 3].reshape(-1), np.linalg.solve(matrix, each), rtol=1e-11, atol=1e-13)
    assert lowest.min() > 0.0


def test_lowest_pivot_detects_indefinite_matrices():
    matrix = _matrix(5, np.random.default_rng(1))
    matrix[9, 9] = -1.0
    b, lowest = np.ones((5, 4, WIDTH)), np.ones((1, WIDTH))
    _solve_rows(_pack_rows(matrix), b, b.copy(), lowest)
    assert lowest.max() < 0.0 and np.isfinite(b).all()
