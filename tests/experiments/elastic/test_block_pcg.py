"""The iterative solution is the direct one."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.elastic.block_pcg import solve
from hairpipe.graphs.experiments.elastic.matter import Rubber
from hairpipe.graphs.experiments.elastic.spring_assembly import add_altitudes, add_linear
from hairpipe.graphs.experiments.elastic.spring_mesh import solid_springs


@pytest.mark.parametrize("held", [False, True])
def test_solution_is_for_free_unknowns(block, as_dense, held):
    springs = solid_springs(block, Rubber(10.0, 1.0))
    rng = np.random.default_rng(1)
    x = block.points + 0.1 * rng.normal(size=block.points.shape)
    A, b = np.zeros((len(springs.pattern.column), 3, 3)), rng.normal(size=x.shape)
    A[springs.pattern.diagonal] = np.eye(3)
    add_linear(A, np.zeros_like(x), x, 0 * x, np.zeros(len(springs.pairs)), springs, 1.0, 0.0)
    add_altitudes(A, np.zeros_like(x), x, 0 * x, springs, 1.0, 0.0)
    free = np.ones_like(x)
    if held:
        free[rng.random(x.shape) < 0.3] = 0.0
    found, residual, made = solve(A, b, springs.pattern, free, 1e-12, 500)
    full, keep = as_dense(A, springs.pattern), free.ravel() > 0
    exact = np.zeros(x.size)
    exact[keep] = np.linalg.solve(full[np.ix_(keep, keep)], b.ravel()[keep])
    np.testing.assert_allclose(found.ravel(), exact, atol=1e-9)
    np.testing.assert_allclose(residual.ravel(), full @ exact - b.ravel(), atol=1e-8)
    assert 0 < made < 200
