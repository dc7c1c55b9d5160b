"""Laws of the implicit linear spring."""

import numpy as np
import pytest

from hairpipe.sim.forces.spring import add_spring, multiplier

K, REST = 3.0, 0.8


def _apply(system, points, offset, tension=0.0):
    s = system(points)
    s.T[0, offset - 1] = tension
    add_spring(s.A, s.b, s.x, s.T, 0, offset, K, 1 / REST, 1.0)
    return s


@pytest.mark.parametrize("offset", [1, 2, 3])
def test_force_is_minus_energy_gradient(system, negative_gradient, offset):
    points = np.random.default_rng(offset).normal(size=(4, 3))

    def energy(x):
        return K / 2 * (np.linalg.norm(x[offset] - x[0]) - REST) ** 2 / REST

    np.testing.assert_allclose(
        _apply(system, points, offset).force, negative_gradient(energy, points), rtol=1e-6, atol=1e-8
    )


def test_stiffness_with_its_own_tension_is_the_exact_hessian(system):
    points = np.array([[0.0, 0, 0], [0.7, 0.8, 0.3], [2, 0, 0], [3, 0, 0]])
    tension = K * (np.linalg.norm(points[1]) / REST - 1)
    assert tension > 0
    dense = _apply(system, points, 1, tension).stiffness
    step = 1e-6
    for i in range(6):
        moved = np.zeros(12)
        moved[i] = step
        change = (
            _apply(system, points + moved.reshape(4, 3), 1).force
            - _apply(system, points - moved.reshape(4, 3), 1).force
        )
        np.testing.assert_allclose(dense[:, i], -change.reshape(-1) / (2 * step), rtol=1e-5, atol=1e-7)


def test_compression_leaves_stiffness_positive_semidefinite(system):
    points = np.random.default_rng(5).normal(size=(4, 3))
    eigenvalues = np.linalg.eigvalsh(_apply(system, points, 2, tension=-10.0).stiffness)
    assert eigenvalues.min() > -1e-12


def test_momentum_and_angular_momentum_are_kept(system):
    points = np.random.default_rng(6).normal(size=(4, 3))
    force = _apply(system, points, 3).force
    np.testing.assert_allclose(force.sum(0), 0, atol=1e-14)
    np.testing.assert_allclose(np.cross(points, force).sum(0), 0, atol=1e-13)


def test_multiplier_is_the_linearised_tension():
    rng = np.random.default_rng(7)
    x, dx = rng.normal(size=(2, 4, 3))
    wide = np.repeat(x[:, :, None], 8, axis=2), np.repeat(dx[:, :, None], 8, axis=2)
    tension = _multiplier(*wide)
    d = (x[2] - x[0]) / np.linalg.norm(x[2] - x[0])
    np.testing.assert_allclose(tension, K * (d @ (x[2] + dx[2] - x[0] - dx[0]) / REST - 1))


def _multiplier(x, dx):
    from numba import njit

    from hairpipe.sim.lanes import store

    @njit
    def evaluate(x, dx, out):
        store(out, (0,), multiplier(x, dx, 0, 2, K, 1 / REST))

    out = np.empty((1, 8))
    evaluate(x, dx, out)
    return out[0, 0]
