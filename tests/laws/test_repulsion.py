"""Repulsion is the gradient of its energy, and its slope that of a stage."""

import pytest
from numba import njit

from hairpipe.laws.repulsion import repulsion, repulsion_slope


@njit
def pushed(stiffness, viscosity, overlap, opening):
    return repulsion(stiffness, viscosity, overlap, opening)


@njit
def push_slope(stiffness, viscosity, h):
    return repulsion_slope(stiffness, viscosity, h)


def test_repulsion_is_the_gradient_of_its_energy_and_its_slope_that_of_a_stage():
    k, c, o, h, step = 0.1, 5e-4, 2e-4, 3e-3, 1e-9
    energy = lambda overlap: 0.5 * k * overlap**2  # noqa: E731
    assert pushed(k, c, o, 0.0) == pytest.approx((energy(o + step) - energy(o - step)) / (2 * step), rel=1e-6)
    # At the end of a stage the gap has opened by h times the velocity.
    ahead = lambda v: pushed(k, c, o - h * v, v)  # noqa: E731
    assert push_slope(k, c, h) == pytest.approx(-(ahead(1e-3) - ahead(-1e-3)) / 2e-3, rel=1e-9)
