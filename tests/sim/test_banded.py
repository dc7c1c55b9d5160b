"""The banded solver against dense linear algebra."""

import numpy as np
import pytest

from hairpipe.sim.banded import OFFSET, REACH, ROW, eliminate, substitute
from hairpipe.sim.lanes import WIDTH


def _random_system(particles, rng):
    """A symmetric positive definite matrix of 3 x 3 blocks that reaches REACH particles, and a right-hand side."""
    size = 3 * particles
    matrix = rng.normal(size=(size, size))
    block = np.arange(size) // 3
    matrix[np.abs(block[:, None] - block[None, :]) > REACH] = 0.0
    matrix = matrix + matrix.T
    return matrix + np.eye(size) * (np.abs(matrix).sum(1).max() + 1), rng.normal(size=size)


def _pack(matrix, A, lane):
    particles = len(A)
    blocks = matrix.reshape(particles, 3, particles, 3).transpose(0, 2, 1, 3)
    for p in range(particles):
        A[p, :OFFSET, lane] = blocks[p, p][np.triu_indices(3)]
        for o in range(1, min(REACH, particles - 1 - p) + 1):
            A[p, OFFSET + 9 * (o - 1) : OFFSET + 9 * o, lane] = blocks[p, p + o].reshape(-1)


@pytest.mark.parametrize("particles", [1, 2, 3, 4, 9, 30])
def test_solution_agrees_with_dense_solve(particles):
    rng = np.random.default_rng(particles)
    A, b = np.zeros((particles, ROW, WIDTH)), np.empty((particles, 3, WIDTH))
    expected = np.empty_like(b)
    for lane in range(WIDTH):
        matrix, right = _random_system(particles, rng)
        _pack(matrix, A, lane)
        b[:, :, lane] = right.reshape(-1, 3)
        expected[:, :, lane] = np.linalg.solve(matrix, right).reshape(-1, 3)
    for p in range(particles):
        eliminate(A, b, p, particles)
    substitute(A, b, particles)
    np.testing.assert_allclose(b, expected, rtol=1e-11, atol=1e-13)
