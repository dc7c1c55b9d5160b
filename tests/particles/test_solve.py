"""The system of a step is solved as a dense one is."""

import numpy as np
import pytest

from hairpipe.particles.model import build_model
from hairpipe.particles.solve import build_system, hold, set_blocks, solve, take_off

HELD = {3: (0.0, 0.6, 0.8), 20: (1.0, 0.0, 0.0)}
"""Of those that are free: along what they are held."""
DAMPER = 0.5


def blocks_of(matrix, k):
    return matrix[3 * k : 3 * k + 3, 3 * k : 3 * k + 3]


@pytest.fixture
def systems(particles):
    """The system of the particles' links with random numbers, and the same as a dense matrix."""
    links, deep, rng = build_model(particles).links, int(np.sum(particles.arcs < 0.0)), np.random.default_rng(2)
    count, system = len(particles.points), build_system(links, deep)
    joins = rng.normal(size=(len(links.ends), 4))
    joins[:, 3] **= 2
    system.joins[:] = joins[links.by].ravel()
    matrix = 0.1 * np.eye(3 * count)
    for (i, j), join in zip(links.ends, joins, strict=True):
        pull = np.outer(join[:3], join[:3]) + join[3] * np.eye(3)
        for a, b, sign in ((i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)):
            matrix[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += sign * pull
    set_blocks(system, np.array([blocks_of(matrix, k)[np.triu_indices(3)] for k in range(count)]))
    return system, matrix, deep


def filled(vectors):
    return np.pad(vectors, ((0, 0), (0, 1))).astype(np.float32).ravel()


def test_the_solution_and_the_residual_equal_those_of_the_dense_matrix(systems):
    system, matrix, deep = systems
    count, rng = len(matrix) // 3, np.random.default_rng(3)
    pushes = rng.normal(size=(count, 3))
    pushes[:deep] = 0.0
    change, residual = np.zeros(4 * count, np.float32), filled(pushes)
    assert 5 < solve(system, residual, change, 1e-6, 0.0) < 200
    free = matrix[3 * deep :, 3 * deep :]
    expected = np.linalg.solve(free, pushes[deep:].ravel()).reshape(-1, 3)
    found = change.reshape(-1, 4)[deep:]
    assert found[:, :3] == pytest.approx(expected, abs=1e-4 * np.abs(expected).max()) and not found[:, 3].any()
    take_off(system, change, residual)
    left = pushes[deep:].ravel() - free @ found[:, :3].astype(float).ravel()
    assert residual.reshape(-1, 4)[deep:, :3].ravel() == pytest.approx(left, abs=1e-4)


def test_held_particles_are_fixed_along_the_normal_and_damped_across_it(systems):
    system, matrix, deep = systems
    count = len(matrix) // 3
    pushes = np.random.default_rng(4).normal(size=(count, 3))
    pushes[:deep] = 0.0
    for k, normal in HELD.items():
        n, k = np.array(normal), deep + k
        hold(system, k, tuple(n), DAMPER)
        across = np.eye(3) - np.outer(n, n)
        matrix[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] += DAMPER * np.eye(3)
        pushes[k] = across @ pushes[k]
        for columns in (matrix, matrix.T):
            columns[3 * k : 3 * k + 3] = across @ columns[3 * k : 3 * k + 3]
        blocks_of(matrix, k)[:] += np.outer(n, n)
    change = np.zeros(4 * count, np.float32)
    solve(system, filled(pushes), change, 1e-6, 0.0)
    expected = np.linalg.solve(matrix[3 * deep :, 3 * deep :], pushes[deep:].ravel()).reshape(-1, 3)
    found = change.reshape(-1, 4)[deep:, :3]
    assert found == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())
    assert all(abs(found[k] @ normal) < 1e-6 for k, normal in HELD.items())
