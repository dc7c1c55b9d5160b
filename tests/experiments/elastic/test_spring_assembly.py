"""Laws of the forces and of the matrix of a mesh."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.elastic.matter import Fabric, Rubber
from hairpipe.graphs.experiments.elastic.sheets import build_noodle
from hairpipe.graphs.experiments.elastic.spring_assembly import add_altitudes, add_linear, find_tensions, spring_energy
from hairpipe.graphs.experiments.elastic.spring_mesh import shell_springs, solid_springs


def forces(springs, x, v=None, damping=0.0, h=1.0, tension=False):
    """Force (n, 3) and blocks of the matrix."""
    A, b = np.zeros((len(springs.pattern.column), 3, 3)), np.zeros_like(x)
    v, T = np.zeros_like(x) if v is None else v, np.zeros(len(springs.pairs))
    if tension:
        find_tensions(T, x, np.zeros_like(x), springs)
    add_linear(A, b, x, v, T, springs, h, damping)
    add_altitudes(A, b, x, v, springs, h, damping)
    return b, A


@pytest.fixture(params=["selected", "none"])
def solid(request, block):
    return solid_springs(block, Rubber(10.0, 1.0, altitudes=request.param)), block.points


def test_force_is_minus_the_gradient_of_the_energy(solid):
    springs, points = solid
    x = points + 0.15 * np.random.default_rng(1).normal(size=points.shape)
    slope = np.zeros_like(x)
    for i in np.ndindex(x.shape):
        step = np.zeros_like(x)
        step[i] = 1e-6
        slope[i] = (spring_energy(x + step, springs) - spring_energy(x - step, springs)) / 2e-6
    np.testing.assert_allclose(forces(springs, x)[0], -slope, rtol=1e-6, atol=1e-6)


def test_a_shell_too_has_the_force_of_its_energy():
    shell = build_noodle(1.0, 0.3, 4, 6, 0.0)
    springs = shell_springs(shell, Fabric(100.0, 0.1, 1.0))
    x = shell.points + 0.02 * np.random.default_rng(2).normal(size=shell.points.shape)
    change = np.random.default_rng(3).normal(size=x.shape)
    slope = (spring_energy(x + 1e-6 * change, springs) - spring_energy(x - 1e-6 * change, springs)) / 2e-6
    assert np.sum(forces(springs, x)[0] * change) == pytest.approx(-slope, rel=1e-6)


def test_at_rest_nothing_acts(solid):
    springs, points = solid
    np.testing.assert_allclose(forces(springs, points)[0], 0, atol=1e-13)


def test_momentum_is_kept(solid):
    springs, points = solid
    rng = np.random.default_rng(4)
    x, v = points + 0.2 * rng.normal(size=points.shape), rng.normal(size=points.shape)
    force, _ = forces(springs, x, v, damping=0.3)
    np.testing.assert_allclose(force.sum(axis=0), 0, atol=1e-11)
    np.testing.assert_allclose(np.cross(x, force).sum(axis=0), 0, atol=1e-10)


def test_matrix_is_symmetric_and_positive(solid, as_dense):
    springs, points = solid
    x = points + 0.2 * np.random.default_rng(5).normal(size=points.shape)
    full = as_dense(forces(springs, x, tension=True)[1], springs.pattern)
    np.testing.assert_allclose(full, full.T, atol=1e-12)
    assert np.linalg.eigvalsh(full).min() > -1e-10


def test_matrix_is_the_slope_of_the_force_at_rest(block, as_dense):
    springs = solid_springs(block, Rubber(10.0, 1.0))
    full = as_dense(forces(springs, block.points)[1], springs.pattern)
    change = np.random.default_rng(6).normal(size=block.points.shape)
    slope = (forces(springs, block.points + 1e-7 * change)[0] - forces(springs, block.points - 1e-7 * change)[0]) / 2e-7
    # At rest several altitudes of these tetrahedra tie, and all have their rest height: any of them gives a force.
    assert full.shape == (81, 81) and np.sum(slope * change) < 0 < change.ravel() @ full @ change.ravel()
    none = solid_springs(block, Rubber(10.0, 1.0, altitudes="none"))
    full = as_dense(forces(none, block.points)[1], none.pattern)
    slope = (forces(none, block.points + 1e-7 * change)[0] - forces(none, block.points - 1e-7 * change)[0]) / 2e-7
    np.testing.assert_allclose(-full @ change.ravel(), slope.ravel(), rtol=1e-5, atol=1e-6)


def test_damping_resists_a_change_of_shape_only(solid):
    springs, points = solid
    turning = np.cross([0.3, 1.0, -0.5], points) + np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(forces(springs, points, turning, damping=1.0)[0], 0, atol=1e-12)
    v = np.random.default_rng(7).normal(size=points.shape)
    assert np.sum(forces(springs, points, v, damping=1.0)[0] * v) < 0
