"""Hair shields hair as the balance of momentum says; the wind takes hold of all the fibre of particles."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hairpipe.laws.drag import law_of, normal_drag
from hairpipe.laws.settings import Coefficients, Shielding, Wind
from hairpipe.shot.breeze import MOST_NODES, Breeze, LooseFibres, add_wind, fraction, shield_of
from hairpipe.solve.interactions import Start

DIAMETER, RHO, MU = 8e-5, 1.2, 1.8e-5
DEPTH = 0.2


def slab(spacing=0.0025, wind=(3.0, 0.0, 0.0), tilt=0.0):
    """Straight hairs that stand evenly in 0 < x < DEPTH, across the wind or tilted to it, and their frontal area."""
    x, z = np.meshgrid(np.arange(spacing / 2, DEPTH, spacing), np.arange(spacing / 2, 0.1, spacing))
    roots = np.stack([x.ravel(), 0 * x.ravel(), z.ravel()], axis=1)
    direction = np.array([np.sin(tilt), np.cos(tilt), 0.0])
    points = (roots[:, None] + np.linspace(0, 0.1, 11)[:, None] * direction).reshape(-1, 3)
    offsets = np.arange(0, len(points) + 1, 11).astype(np.int32)
    return points, offsets, DIAMETER / spacing**2


def left(points, offsets, wind, places):
    shield = shield_of(points, offsets, wind, law_of(wind, DIAMETER), DIAMETER)
    assert shield is not None
    return np.array([fraction(shield, *place) for place in places])


def drag_coefficient(speed):
    re = RHO * DIAMETER * speed / MU
    return 1.18 + 6.8 / re**0.89 + 1.96 / re**0.5


@pytest.mark.parametrize("hairs", [0.1, 0.5])
def test_a_slab_weakens_the_wind_as_the_balance_of_momentum_says(hairs):
    points, offsets, area = slab()
    wind = Wind((3.0, 0.0, 0.0), shielding=Shielding(0.01, hairs))
    x = np.linspace(0.03, 0.17, 8)
    found = left(points, offsets, wind, np.stack([x, 0 * x + 0.05, 0 * x + 0.05], axis=1))
    solved = solve_ivp(
        lambda s, u: -0.5 * drag_coefficient(u) * hairs * area * u, (0, x[-1]), [3.0], t_eval=x, rtol=1e-6
    )
    np.testing.assert_allclose(found, solved.y[0] / 3.0, atol=0.003)
    if hairs < 0.3:
        straight = np.exp(-0.5 * drag_coefficient(3.0) * hairs * area * x)
        np.testing.assert_allclose(found, straight, rtol=0.05)


def test_a_strand_that_stands_for_four_shields_as_four_in_its_place():
    points, offsets, _ = slab()
    wind, four = Wind((3.0, 0.0, 0.0), shielding=Shielding(0.01, 0.1)), np.tile(points, (4, 1))
    every = np.concatenate([offsets, *(offsets[1:] + k * len(points) for k in (1, 2, 3))]).astype(np.int32)
    law = law_of(wind, DIAMETER)
    many = shield_of(four, every, wind, law, DIAMETER)
    one = shield_of(points, offsets, wind, law, DIAMETER, np.full(len(points), 2.0))
    np.testing.assert_allclose(one.left, many.left, rtol=1e-11)
    assert many.left.mean() < 0.95 * shield_of(points, offsets, wind, law, DIAMETER).left.mean()


def test_hair_of_two_diameters_shields_by_the_drag_of_each():
    """Every other layer is of half and of one and a half of the diameter, against the balance of momentum."""
    points, offsets, area = slab()
    wind = Wind((3.0, 0.0, 0.0), shielding=Shielding(0.01, 0.5))
    thick = np.round(points[:, 0] / 0.0025 - 0.5) % 2 == 0
    sizes = np.where(thick, 1.5, 0.5)
    shield = shield_of(points, offsets, wind, law_of(wind, DIAMETER), DIAMETER, sizes=sizes)
    x = np.linspace(0.03, 0.17, 8)

    def slope(_, u):
        return -0.25 * 0.5 * area * u * sum(size * drag_coefficient(size * u) for size in (0.5, 1.5))

    solved = solve_ivp(slope, (0, x[-1]), [3.0], t_eval=x, rtol=1e-6).y[0] / 3.0
    np.testing.assert_allclose([fraction(shield, one, 0.05, 0.05) for one in x], solved, atol=0.006)


def test_hair_along_the_wind_does_not_shield():
    points, offsets, _ = slab(tilt=np.pi / 2)
    wind = Wind((3.0, 0.0, 0.0), shielding=Shielding(0.01, 100.0))
    np.testing.assert_allclose(left(points, offsets, wind, points[::50]), 1.0, atol=1e-9)


def test_prescribed_coefficients_take_the_same_speed_from_every_layer():
    """c_n U is then the force: dU/ds = -c_n a / (rho d), whatever U."""
    points, offsets, area = slab()
    wind = Wind((3.0, 0.0, 0.0), coefficients=Coefficients(2e-4, 0.0), shielding=Shielding(0.01, 0.1))
    x = np.linspace(0.03, 0.17, 8)
    found = left(points, offsets, wind, np.stack([x, 0 * x + 0.05, 0 * x + 0.05], axis=1))
    np.testing.assert_allclose(found, 1.0 - 2e-4 * 0.1 * area * x / (RHO * DIAMETER) / 3.0, atol=1e-3)


def test_a_turned_world_is_shielded_alike():
    points, offsets, _ = slab()
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    places = np.array([[0.05, 0.05, 0.05], [0.1, 0.05, 0.05], [0.15, 0.04, 0.06]])
    wind = Wind((3.0, 0.0, 0.0), shielding=Shielding(0.01, 0.3))
    turned = Wind(tuple(turn @ [3.0, 0.0, 0.0]), shielding=wind.shielding)
    one, two = left(points, offsets, wind, places), left(points @ turn.T, offsets, turned, places @ turn.T)
    np.testing.assert_allclose(one, two, rtol=0.05)
    assert one[2] < 0.9 * one[0]


def test_dense_hair_lets_nothing_through_and_a_long_segment_counts_all_along_it():
    points, offsets, _ = slab()
    thick = left(points, offsets, Wind(shielding=Shielding(0.01, 1e6)), points[::97])
    assert np.isfinite(thick).all() and (thick >= 0.0).all() and thick.min() < 1e-5
    ends, few = points.reshape(-1, 11, 3)[:, [0, 10]].reshape(-1, 3), (offsets // 11 * 2).astype(np.int32)
    wind, places = Wind((3.0, 0.0, 0.0), shielding=Shielding(0.01, 0.3)), np.array([[0.1, 0.05, 0.05]])
    np.testing.assert_allclose(left(ends, few, wind, places), left(points, offsets, wind, places), rtol=0.02)


def test_the_grid_stays_small_however_far_hair_is_spread():
    points, offsets, _ = slab()
    wind = Wind((3.0, 0.0, 0.0), shielding=Shielding())
    for far in (1e4, 1e30):
        points[11 * 7] = far
        shield = shield_of(points, offsets, wind, law_of(wind, DIAMETER), DIAMETER)
        assert shield is not None and shield.left.size <= MOST_NODES and np.isfinite(shield.left).all()
    assert shield_of(points, offsets, Wind((0.0, 0.0, 0.0), shielding=Shielding()), law_of(wind, 8e-5), 8e-5) is None


def test_shield_is_constant_during_a_step():
    points, offsets, _ = slab()
    wind = Wind((3.0, 0.0, 0.0), shielding=Shielding())
    counted, fresh = Breeze(wind, DIAMETER, offsets), Breeze(wind, DIAMETER, offsets)
    counted.begin(Start(points, 0.0 * points, np.ones(len(points)), 0.0, 0.0, 1e-3))
    np.testing.assert_array_equal(counted.air(points, 0.0), fresh.air(points, 0.0))
    ahead = points - np.array([1.0, 0.0, 0.0])  # of what was counted, where the wind is still what it was
    np.testing.assert_allclose(counted.air(ahead, 0.0)[:, 0], 3.0, rtol=0.05)
    assert fresh.air(ahead, 0.0)[:, 0].min() < 1.0


def test_a_prescribed_coefficient_is_that_of_any_diameter():
    points, offsets, _ = slab()
    sizes = np.linspace(0.5, 2.0, len(points))
    for given in (0.0, 1e-4):
        wind = Wind((3.0, 0.0, 0.0), coefficients=Coefficients(given, 0.0), shielding=Shielding())
        one, other = (
            shield_of(points, offsets, wind, law_of(wind, DIAMETER), DIAMETER, sizes=each) for each in (None, sizes)
        )
        np.testing.assert_array_equal(one.left, other.left)


SEGMENT = 0.02


def forces_of(wind, points, counts):
    down, still = np.tile([0.0, -1.0, 0.0], (len(points), 1)), np.zeros((len(points), 3))
    push, drag = np.zeros((len(points), 3)), np.zeros((len(points), 6))
    add_wind(wind, LooseFibres(points, down, still, np.asarray(counts, float), SEGMENT, DIAMETER), 0.0, push, drag)
    return push, drag


def test_across_the_hair_it_pushes_as_on_a_cylinder_of_all_that_length():
    wind = Wind((0.0, 0.0, -2.0))
    push, drag = forces_of(wind, np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), [40, 90])
    expected = np.array([40, 90]) * SEGMENT * normal_drag(law_of(wind, DIAMETER), 2.0)
    assert push == pytest.approx(-2.0 * expected[:, None] * (0.0, 0.0, 1.0), abs=1e-15)
    assert drag[:, [0, 5]] == pytest.approx(np.stack([expected, expected], axis=1))


def test_hair_keeps_the_wind_from_the_hair_behind_it():
    points = np.zeros((400, 3))
    points[:, 2] = -np.linspace(0.0, 0.1, 400)
    push, _ = forces_of(Wind((0.0, 0.0, -2.0), shielding=Shielding()), points, np.full(400, 0.4))
    assert push[-1, 2] > 0.5 * push[0, 2] and push[0, 2] < 0.0
