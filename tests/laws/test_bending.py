"""Laws of the bending force of a plain chain."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.simd import load
from hairpipe.laws.bending import add_bending

from .checks import check_law

B = 2.0


@njit
def _add(A, b, x, h, hh):
    add_bending(A, b, x, 0, B + 0.0 * load(x, (0, 0)), h, hh)


def _apply(system, points, h=1.0, hh=1.0):
    s = system(points)
    _add(s.A, s.b, s.x, h, hh)
    return s


@pytest.fixture
def points():
    return np.random.default_rng(1).normal(size=(3, 3))


def test_it_keeps_the_laws_of_its_energy(system, points):
    def energy(x):
        return B / 2 * np.sum((x[0] - 2 * x[1] + x[2]) ** 2)

    s = _apply(system, points)
    check_law(energy, lambda x: _apply(system, x).force, s.stiffness, points)
    assert np.linalg.eigvalsh(s.stiffness).min() > -1e-13
    np.testing.assert_allclose(s.force.reshape(-1), -s.stiffness @ points.reshape(-1), atol=1e-13)  # it is linear
    line = np.arange(3.0)[:, None] * [0.3, -1.0, 0.2]
    np.testing.assert_allclose(_apply(system, line).force, 0, atol=1e-15)


def test_energy_is_that_of_a_bent_rod(system):
    """On a circle of radius R, with B = EI / l^3: E = EI l / (2 R^2) for the joint, to (l / R)^2 / 12."""
    radius, length = 5.0, 1.0
    around = np.arange(3) * 2 * np.arcsin(length / radius / 2)
    x = radius * np.stack([np.cos(around), np.sin(around), np.zeros(3)], axis=1)
    energy = -0.5 * np.sum(_apply(system, x).force * x)  # quadratic: E = x K x / 2
    assert energy == pytest.approx(B * length**3 * length / (2 * radius**2), rel=(length / radius) ** 2 / 6)


def test_an_explicit_force_has_no_stiffness(system, points):
    s = _apply(system, points, h=0.5, hh=0.0)
    assert np.all(s.A == 0)
    np.testing.assert_allclose(s.force, 0.5 * _apply(system, points).force, rtol=1e-14)
