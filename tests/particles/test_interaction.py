"""Pairs of particles, the smoothing kernel, and hair that acts on hair."""

import numpy as np
import pytest

from hairpipe.particles.interaction import Law, exchange, find_pairs
from hairpipe.particles.model import kernel, shape, slope

H, DT = 0.02, 1 / 24


class Crowd:
    """Particles close together that move and point at random."""

    def __init__(self, count=150, seed=0, deep=0):
        rng = np.random.default_rng(seed)
        self.points, self.velocities = rng.uniform(0.0, 0.08, (count, 3)), rng.normal(size=(count, 3))
        directions = rng.normal(size=(count, 3))
        self.directions = directions / np.linalg.norm(directions, axis=1)[:, None]
        self.masses = rng.uniform(1e-5, 2e-5, count)
        self.inverses = np.where(np.arange(count) < deep, 0.0, 1.0 / self.masses)

    # Without a bound, one times nothing is no number, and bounds nothing.
    def after(self, pressure=0.0, collision=0.0, friction=0.0, bound=np.inf, rest=np.inf):
        pairs = find_pairs(self.masses, self.points, H)
        law = Law(pressure, collision, friction, bound, H, 1.5e-5, np.full(len(self.points), rest))
        velocities = self.velocities.copy()
        exchange(law, pairs, self.inverses, self.points, self.directions, DT, velocities)
        return velocities

    def energy(self, velocities):
        return 0.5 * self.masses @ np.sum(velocities**2, axis=1)


@pytest.mark.parametrize(
    "law", [{"pressure": 4.0, "rest": 1.0}, {"collision": 50.0}, {"collision": 50.0, "friction": 50.0}]
)
def test_momentum_is_kept(law):
    crowd = Crowd()
    after = crowd.after(**law)
    assert np.abs(after - crowd.velocities).max() > 0.1
    scale = crowd.masses @ np.linalg.norm(crowd.velocities, axis=1)
    assert np.abs(crowd.masses @ (after - crowd.velocities)).max() < 1e-15 * scale


@pytest.mark.parametrize("rate", [1.0, 20.0, 200.0, 1e4])
def test_collision_and_friction_take_energy_at_any_rate(rate):
    for law in ({"collision": rate}, {"friction": rate}, {"collision": rate, "friction": rate, "bound": 0.3}):
        crowd = Crowd(seed=1)
        assert crowd.energy(crowd.after(**law)) < crowd.energy(crowd.velocities)


def test_prescribed_particles_push_others_but_are_not_pushed():
    crowd = Crowd(deep=30)
    after = crowd.after(4.0, 50.0, 50.0, 0.3, 1.0)
    assert np.array_equal(after[:30], crowd.velocities[:30])
    assert not np.array_equal(after[30:], crowd.velocities[30:])


def test_pressure_acts_above_rest_density_only_and_does_not_overshoot():
    """A pair at rest: that too dense parts, and the stiffer the more, up to where its density would be right."""
    crowd = Crowd(2)
    crowd.points, crowd.velocities = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0]]), np.zeros((2, 3))
    crowd.masses = np.full(2, 1.5e-5)
    crowd.inverses = 1.0 / crowd.masses
    dense = find_pairs(crowd.masses, crowd.points, H).density[0]
    assert not crowd.after(1.0, rest=1.01 * dense).any()
    speeds = [np.ptp(crowd.after(k, rest=0.9 * dense)[:, 0]) for k in (0.01, 0.1, 1.0, 1e2, 1e6)]
    assert (np.diff(speeds) > 0.0).all() and speeds[-1] < 1.1 * speeds[-2]
    # Explicit, a soft one: (16) with both pressures alike.
    r = 0.01 / H
    slope = 1.5e-5 / (np.pi * H**4) * (3.0 * r - 2.25 * r**2)
    expected = 4.0 * 0.01 * 0.1 / dense * slope * DT
    assert speeds[0] == pytest.approx(expected, rel=0.05)


def test_friction_is_bounded_by_the_normal_force():
    """Two that meet head on with a sideways speed: of that at most bound times what the collision took."""
    crowd = Crowd(2)
    crowd.points = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0]])
    crowd.directions = np.tile([0.0, 0.0, 1.0], (2, 1))
    crowd.velocities = np.array([[0.1, 0.0, 0.0], [-0.1, 1.0, 0.0]])
    change = np.diff(crowd.after(0.0, 50.0, 1e4, 0.3), axis=0)[0] - np.diff(crowd.velocities, axis=0)[0]
    assert change[0] > 0.05 and -change[1] == pytest.approx(0.3 * change[0], rel=1e-9)


@pytest.mark.parametrize("spread", [(1.0, 1.0, 1.0), (10.0, 0.01, 1.0), (1e3, 1e3, 1e3)])
def test_all_pairs_are_found_once(spread):
    points = np.random.default_rng(0).normal(size=(400, 3)) * spread
    points[7:20] = points[7]
    points[20:24] = 1e5 * spread[0] + 0.01 * points[20:24]
    h = 0.15
    masses = np.linspace(1.0, 2.0, 400)
    found = find_pairs(masses, points, h)
    pairs = found.ends
    distances = np.linalg.norm(points[:, None] - points, axis=2)
    expected = np.argwhere(np.triu(distances < 2.0 * h, 1))
    assert sorted(map(tuple, np.sort(pairs, axis=1).tolist())) == sorted(map(tuple, expected.tolist()))
    assert found.apart == pytest.approx(distances[tuple(pairs.T)])
    assert found.density == pytest.approx(kernel(distances, h) @ masses)
    for k in (0, 7, 399):
        assert sorted(found.by[found.rows[k] : found.rows[k + 1]]) == sorted(np.flatnonzero((pairs == k).any(axis=1)))


def test_its_integral_is_1_and_its_value_at_0_that_of_the_paper():
    h, r = 0.03, np.linspace(0.0, 0.07, 20_001)
    assert np.sum(4.0 * np.pi * r**2 * kernel(r, h)) * r[1] == pytest.approx(1.0, rel=1e-6)
    assert kernel(np.zeros(1), h)[0] == pytest.approx(1.0 / (np.pi * h**3))
    assert not kernel(np.array([2.0 * h, 5.0 * h]), h).any()


def test_shape_and_slope_equal_the_kernel_and_its_derivative():
    q, step = np.linspace(0.05, 2.5, 50), 1e-5
    assert [shape.py_func(x) for x in q] == pytest.approx(4.0 * np.pi * kernel(q, 1.0), abs=1e-12)
    differences = [(shape.py_func(x + step) - shape.py_func(x - step)) / (2.0 * step) for x in q]
    assert [slope.py_func(x) for x in q] == pytest.approx(differences, abs=1e-5)
