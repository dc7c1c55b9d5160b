"""A goal is the gradient of its energy, and a free point swings with its frequency."""

import numpy as np
import pytest
from numba import njit

from hairpipe.laws.goal import goal, goal_slope, spring_of


@njit
def pulled(stiffness, damping, away, slip):
    return goal(stiffness, damping, away, slip)


@njit
def pull_slope(stiffness, damping, h):
    return goal_slope(stiffness, damping, h)


def test_a_goal_is_the_gradient_of_its_energy_and_its_frequency_that_of_a_free_point():
    mass, frequency, ratio, h = 3e-8, 4.0, 0.7, 2e-3
    k, d = (float(each[0]) for each in spring_of(np.array([mass]), np.array([frequency]), ratio))
    assert np.sqrt(k / mass) / (2 * np.pi) == pytest.approx(frequency)
    assert d == pytest.approx(ratio * 2 * np.sqrt(k * mass))  # the ratio of critical damping
    step, x = 1e-7, 2e-3
    energy = lambda away: 0.5 * k * away**2  # noqa: E731
    assert pulled(k, d, x, 0.0) == pytest.approx((energy(x + step) - energy(x - step)) / (2 * step), rel=1e-6)
    ahead = lambda v: pulled(k, d, x - h * v, -v)  # noqa: E731
    assert pull_slope(k, d, h) == pytest.approx(-(ahead(1.0) - ahead(-1.0)) / 2.0, rel=1e-9)
