"""Repulsion, adhesion and goals: forces are gradients of their energies, derivatives those of the forces."""

import numpy as np
import pytest
from numba import njit

from hairpipe.laws.adhesion import adhesion, stiffness_of
from hairpipe.laws.goal import goal, goal_slope, spring_of
from hairpipe.laws.repulsion import repulsion, repulsion_slope
from hairpipe.laws.settings import Force, Stiction

STICKY = Stiction(reach=5e-4, release=1.5e-3, force=Force(2e-5))
SLACK = STICKY.release - STICKY.reach


@njit
def pushed(stiffness, viscosity, overlap, opening):
    return repulsion(stiffness, viscosity, overlap, opening)


@njit
def push_slope(stiffness, viscosity, h):
    return repulsion_slope(stiffness, viscosity, h)


@njit
def stuck(stiffness, fraction, longer, slack, inverse_mass):
    return adhesion(stiffness, fraction, longer, slack, inverse_mass)


@njit
def pulled(stiffness, damping, away, slip):
    return goal(stiffness, damping, away, slip)


@njit
def pull_slope(stiffness, damping, h):
    return goal_slope(stiffness, damping, h)


def test_repulsion_is_the_gradient_of_its_energy_and_its_slope_that_of_a_stage():
    k, c, o, h, step = 0.1, 5e-4, 2e-4, 3e-3, 1e-9
    energy = lambda overlap: 0.5 * k * overlap**2  # noqa: E731
    assert pushed(k, c, o, 0.0) == pytest.approx((energy(o + step) - energy(o - step)) / (2 * step), rel=1e-6)
    # At the end of a stage the gap has opened by h times the velocity.
    ahead = lambda v: pushed(k, c, o - h * v, v)  # noqa: E731
    assert push_slope(k, c, h) == pytest.approx(-(ahead(1e-3) - ahead(-1e-3)) / 2e-3, rel=1e-9)


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


def test_a_connection_at_release_has_the_force_of_the_settings():
    k, _ = stuck(stiffness_of(STICKY), 0.5, SLACK, SLACK, 1e6)
    assert k == pytest.approx(stiffness_of(STICKY))
    assert k * SLACK == pytest.approx(STICKY.force.value)


@pytest.mark.parametrize("times", [1.0, 1.5, 4.0, 100.0])
def test_a_connection_that_breaks_in_a_step_does_the_work_of_release(times):
    k, _ = stuck(stiffness_of(STICKY), 0.5, times * SLACK, SLACK, 1e6)
    assert 0.5 * k * (times * SLACK) ** 2 == pytest.approx(0.5 * stiffness_of(STICKY) * SLACK**2)


@pytest.mark.parametrize("times", [0.5, 3.0])
def test_the_damping_of_a_connection_is_a_share_of_critical_and_none_for_held_points(times):
    k, c = stuck(stiffness_of(STICKY), 0.5, times * SLACK, SLACK, 1e7)
    assert c == pytest.approx(0.5 * 2.0 * np.sqrt(k / 1e7))
    assert stuck(stiffness_of(STICKY), 0.5, times * SLACK, SLACK, 0.0)[1] == 0.0
