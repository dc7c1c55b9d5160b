"""Drag of air on a strand: its laws, and the speed at which hair falls."""

import numpy as np
import pytest
from scipy.optimize import root_scalar

from hairpipe.laws.drag import law_of, normal_drag, tangential_drag
from hairpipe.laws.settings import Coefficients, Gusts, Shielding, Wind
from hairpipe.shot.breeze import Breeze
from hairpipe.solve.interactions import Prediction
from hairpipe.strands.material import Material

DIAMETER, LINE, G = Material().diameter, Material().line_density, 9.81
OFFSETS = np.array([0, 7, 12], np.int32)
CHANCE = np.random.default_rng(3)
POINTS, VELOCITIES = CHANCE.normal(size=(12, 3)) * 0.05, CHANCE.normal(size=(12, 3))
PLAIN = Coefficients(3e-4, 1e-4)


def matrices(damping):
    return damping[:, [[0, 1, 2], [1, 3, 4], [2, 4, 5]]]


def prediction(points, velocities, seconds=0.0, active=None):
    active = np.ones(len(points), bool) if active is None else active
    masses, weights = np.ones(len(points)), np.full(len(points), 1e-3)
    return Prediction(points, velocities, velocities, masses, weights, active, 1e-3, seconds, seconds)


def forces(wind, points=POINTS, velocities=VELOCITIES, offsets=OFFSETS, seconds=0.0, active=None):
    """Push, damping as matrices, and the force of both."""
    push, damping = np.zeros_like(points), np.zeros((len(points), 6))
    at = prediction(points, velocities, seconds, active)
    Breeze(wind, DIAMETER, offsets).linearise(at, push, damping)
    full = matrices(damping)
    return push, full, push - np.einsum("pij,pj->pi", full, velocities)


def falling(direction, slope, wind):
    """Speed of a free strand after a fall long enough, by implicit steps of any length."""
    points = np.linspace(0, 0.1, 11)[:, None] * np.array(direction, float)
    mass = np.full((11, 1), LINE * 0.01) * np.array([0.5, *[1.0] * 9, 0.5])[:, None]
    velocities, offsets = np.zeros_like(points), np.array([0, 11], np.int32)
    for _ in range(60):
        push, full, _ = forces(wind, points, velocities, offsets)
        right = mass * velocities + slope * (push + mass * [0.0, -G, 0.0])
        velocities = np.linalg.solve(mass[:, :, None] * np.eye(3) + slope * full, right[..., None])[..., 0]
    return velocities


@pytest.mark.parametrize("coefficients", [None, PLAIN])
def test_strands_have_the_drag_of_their_own_diameter(coefficients):
    """Two strands of two diameters, and a segment between two points, against hair of one diameter."""
    wind = Wind((1.0, 0.5, -2.0), coefficients=coefficients)
    diameters = np.where(np.arange(12) < 7, 40e-6, 160e-6)
    at, found = prediction(POINTS, VELOCITIES), (np.zeros((12, 3)), np.zeros((12, 6)))
    Breeze(wind, DIAMETER, OFFSETS, diameters=diameters).linearise(at, *found)
    for diameter in (40e-6, 160e-6):
        alone = np.zeros((12, 3)), np.zeros((12, 6))
        Breeze(wind, diameter, OFFSETS).linearise(at, *alone)
        own = diameters == diameter
        for mixed, plain in zip(found, alone, strict=True):
            np.testing.assert_allclose(mixed[own], plain[own], rtol=1e-12)
    tapered, middle = (np.zeros((2, 3)), np.zeros((2, 6))), (np.zeros((2, 3)), np.zeros((2, 6)))
    at, ends = prediction(POINTS[:2], VELOCITIES[:2]), np.array([0, 2], np.int32)
    Breeze(wind, DIAMETER, ends, diameters=np.array([100e-6, 20e-6])).linearise(at, *tapered)
    Breeze(wind, 60e-6, ends).linearise(at, *middle)
    np.testing.assert_allclose(tapered[0], middle[0], rtol=1e-12)


@pytest.mark.parametrize("step", [0.03, 10.0])
def test_a_level_hair_falls_as_fast_as_a_cylinder_in_cross_flow(step):
    """1/2 rho d C_D v^2 = m g per length, with C_D of Sucker and Brauer: about 0.4 m/s at Re = 2."""

    def excess(v):
        re = 1.2 * DIAMETER * v / 1.8e-5
        return 0.5 * 1.2 * DIAMETER * v**2 * (1.18 + 6.8 / re**0.89 + 1.96 / re**0.5) - LINE * G

    fallen = falling((1, 0, 0), step, Wind((0.0, 0.0, 0.0)))
    np.testing.assert_allclose(
        fallen, np.tile([0.0, -root_scalar(excess, bracket=(0.01, 10.0)).root, 0.0], (11, 1)), rtol=1e-6, atol=1e-12
    )


def test_an_upright_hair_falls_until_its_friction_carries_it():
    """c_t v = m g with c_t = mu 1.7 Re^0.11: five times as fast as a level one."""

    def excess(v):
        return 1.7 * 1.8e-5 * (1.2 * DIAMETER * v / 1.8e-5) ** 0.11 * v - LINE * G

    speed = root_scalar(excess, bracket=(0.01, 100.0)).root
    fallen = falling((0, 1, 0), 0.5, Wind((0.0, 0.0, 0.0)))
    np.testing.assert_allclose(fallen, np.tile([0.0, -speed, 0.0], (11, 1)), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(("direction", "coefficient"), [((1, 0, 0), 3e-4), ((0, 1, 0), 1e-4)])
def test_prescribed_coefficients_are_those_of_a_metre_of_hair(direction, coefficient):
    wind = Wind((0.3, 0.1, 0.0), coefficients=PLAIN)
    fallen = falling(direction, 20.0, wind)
    assert fallen == pytest.approx(np.tile([0.3, 0.1 - LINE * G / coefficient, 0.0], (11, 1)), rel=1e-6)


def test_slow_air_takes_twice_as_much_across_as_along():
    creep = law_of(Wind(), DIAMETER)
    assert normal_drag(creep, 1e-9) / tangential_drag(creep, 1e-9) == pytest.approx(2.0, rel=0.01)
    assert 4.0 < normal_drag(creep, 1.0) / tangential_drag(creep, 1.0) < 6.0


@pytest.mark.parametrize("plain", [None, PLAIN])
def test_still_air_only_takes_energy(plain):
    push, full, force = forces(Wind((0.0, 0.0, 0.0), coefficients=plain))
    assert not push.any()
    assert (np.sum(force * VELOCITIES, axis=1) < 0.0).all()
    assert (np.linalg.eigvalsh(full) > 0.0).all()


def test_hair_that_moves_with_the_wind_feels_none():
    drift = np.tile([1.0, -2.0, 0.5], (12, 1))
    for plain in (None, PLAIN):
        assert np.abs(forces(Wind((1.0, -2.0, 0.5), coefficients=plain), velocities=drift)[2]).max() < 1e-17


def test_turning_the_world_turns_the_force():
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    wind = np.array([1.0, -2.0, 0.5])
    _, full, force = forces(Wind(tuple(wind)))
    _, other_full, other = forces(Wind(tuple(turn @ wind)), POINTS @ turn.T, VELOCITIES @ turn.T)
    np.testing.assert_allclose(other, force @ turn.T, atol=1e-12 * np.abs(force).max())
    np.testing.assert_allclose(other_full, turn @ full @ turn.T, atol=1e-12 * full.max())


def test_segments_join_no_strands_and_forces_add_up():
    whole = forces(Wind())
    parts = [forces(Wind(), POINTS[a:b], VELOCITIES[a:b], np.array([0, b - a], np.int32)) for a, b in ((0, 7), (7, 12))]
    for now, then in zip(whole, zip(*parts, strict=True), strict=True):
        np.testing.assert_array_equal(now, np.concatenate(then))
    push, damping = np.ones_like(POINTS), np.ones((12, 6))
    Breeze(Wind(), DIAMETER, OFFSETS).linearise(prediction(POINTS, VELOCITIES), push, damping)
    np.testing.assert_allclose(push - 1.0, whole[0], atol=1e-15)


def test_strands_that_are_not_requested_get_nothing_and_change_nothing():
    wind, active = Wind((2.0, 0.3, -1.0), gusts=Gusts(), shielding=Shielding(0.02, 50.0)), np.arange(12) >= 7
    for some, whole in zip(forces(wind, active=active), forces(wind), strict=True):
        np.testing.assert_array_equal(some[active], whole[active])
        assert whole[~active].any() and not some[~active].any()


def test_drag_does_not_depend_on_threads_nor_on_strands_that_are_not_finite(same_on_threads):
    strands = 700
    points = np.cumsum(np.random.default_rng(2).normal(size=(strands * 20, 3)) * 0.003, axis=0)
    velocities, offsets = np.sin(points * 9.0), np.arange(0, len(points) + 1, 20).astype(np.int32)
    wind = Wind((2.0, 0.3, -1.0), gusts=Gusts(), shielding=Shielding(0.02, 50.0))
    _, _, whole = same_on_threads(lambda: forces(wind, points, velocities, offsets, 3.7))
    points[5] = np.nan
    points[6] = np.inf
    _, _, broken = forces(wind, points, velocities, offsets, 3.7)
    assert np.isfinite(broken[20:]).all()
    np.testing.assert_allclose(broken[20:], whole[20:], rtol=0.05, atol=1e-8)
