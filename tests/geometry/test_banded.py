"""The banded solver against dense linear algebra."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.banded import OFFSET, eliminate, fix_lanes, row_size, substitute
from hairpipe.geometry.simd import WIDTH, load


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
