"""Hair thrown at hair does not pass through it."""

import numpy as np
import pytest

from hairpipe.contact.collision import collide
from hairpipe.laws.settings import Collisions, Thickness

from ..rod_scenes import cross, segments_of, thrown

LAW = Collisions(Thickness(3e-4), friction=0.3, attempts=10)
DT = 1 / 30


def collided(before, velocities, masses=None, law=LAW, offsets=None):
    """Positions and velocities after a step, and the outcome."""
    masses = np.full(len(before), 4e-8) if masses is None else masses
    offsets = np.arange(0, len(before) + 1, 2).astype(np.int32) if offsets is None else offsets
    outcome = collide(before, before + DT * velocities, masses, offsets, DT, law)
    return before + DT * (velocities + outcome.change), velocities + outcome.change, outcome


def spans(x, i, j):
    """Volume that segments span, six times, and whether they overlap seen along their common normal."""
    a, c, r = x[i + 1] - x[i], x[j + 1] - x[j], x[j] - x[i]
    n = np.cross(a, c)
    nn = (n * n).sum(-1)
    s, t = (np.cross(r, c) * n).sum(-1) / nn, (np.cross(r, a) * n).sum(-1) / nn
    return (n * r).sum(-1), (s > 0) & (s < 1) & (t > 0) & (t < 1)


def crossed(before, after, i, j):
    """Whether segments pass through each other on straight ways: roots of their volume, a cubic, where they overlap."""
    at = np.array([0.0, 1.0, 2.0, 3.0]) / 3
    volumes = np.stack([spans((1 - k) * before + k * after, i, j)[0] for k in at], 1)
    cubic = volumes @ np.linalg.inv(np.vander(at, increasing=True)).T
    frobenius = np.zeros((len(i), 3, 3))
    frobenius[:, [1, 2], [0, 1]] = 1.0
    frobenius[:, :, 2] = -cubic[:, :3] / cubic[:, 3:]
    found = np.zeros(len(i), bool)
    for root in np.linalg.eigvals(frobenius).T:
        k, real = root.real[:, None], (abs(root.imag) < 1e-9) & (root.real > 0) & (root.real < 1)
        ends = [(1 - k) * before[p] + k * after[p] for p in (i, i + 1, j, j + 1)]
        rows = np.arange(len(i)) * 4
        found |= real & spans(np.stack(ends, 1).reshape(-1, 3), rows, rows + 2)[1]
    return found


def throw(count, seed=0, apart=10.0):
    """Far apart couples of rods of 10 mm thrown through each other at about 10 m/s, with random turns."""
    rng = np.random.default_rng(seed)

    def unit():
        v = rng.normal(size=(count, 3))
        return v / np.linalg.norm(v, axis=1, keepdims=True)

    meeting = apart * np.arange(count)[:, None] * [1.0, 0.0, 0.0]
    when, points, speeds = rng.uniform(0.05, 0.95, count)[:, None] * DT, [], []
    for _ in range(2):
        along, speed, spin = unit(), 10.0 * unit(), rng.normal(size=(count, 3)) * 0.1
        place = rng.uniform(0.1, 0.9, count)[:, None]
        ends = [meeting - 0.01 * place * along, meeting + 0.01 * (1 - place) * along]
        ways = [speed - spin * place, speed + spin * (1 - place)]
        points += [end - when * way for end, way in zip(ends, ways, strict=True)]
        speeds += ways
    return (np.stack(part, 1).reshape(-1, 3) for part in (points, speeds))


def test_two_hairs_at_ten_metres_per_second_do_not_pass():
    before, _ = cross(0.05)
    velocities = np.outer([1, 1, 0, 0], [0.0, -10.0, 0.0])
    after, speeds, outcome = collided(before, velocities)
    assert (outcome.found, outcome.left) == (1, 0) and outcome.change.any(axis=1).all()
    assert after[0, 1] - after[2, 1] == pytest.approx(LAW.thickness.value)
    np.testing.assert_allclose(speeds - velocities, (after - before) / DT - velocities, atol=1e-12)


def test_hair_that_nearly_touches_is_stopped_where_it_is_and_does_not_rebound():
    before, _ = cross(1e-4)
    after, speeds, _ = collided(before, np.outer([1, 1, 0, 0], [0.0, -10.0, 0.0]))
    assert after[0, 1] - after[2, 1] == pytest.approx(1e-4)
    assert speeds[0, 1] - speeds[2, 1] == pytest.approx(0.0, abs=1e-9)


def test_ten_thousand_thrown_pairs_do_not_cross():
    before, velocities = throw(10_000)
    free = before + DT * velocities
    i = np.arange(0, len(before), 4)
    after, _, outcome = collided(before, velocities)
    assert outcome.found == len(i) and crossed(before, free, i, i + 2).all()
    assert outcome.left == 0
    assert not crossed(before, after, i, i + 2).any()


def test_a_cloud_ends_with_almost_no_crossing_and_no_speed_is_added():
    before, velocities = thrown(300, 0.03, 0.01, 0.3, 7)
    after, speeds, outcome = collided(before, velocities)
    i, j = (segments_of(300)[k] for k in np.triu_indices(300, 1))
    assert outcome.found > 100
    assert crossed(before, after, i, j).sum() == outcome.left < 0.02 * outcome.found
    assert (speeds**2).sum() < (velocities**2).sum()
    assert np.abs(speeds).max() < 2 * np.abs(velocities).max()
    still = ~outcome.change.any(axis=1)
    assert (after[still] == (before + DT * velocities)[still]).all()


def test_momentum_is_kept():
    before, velocities = throw(50, 3)
    masses = np.random.default_rng(0).uniform(1e-8, 9e-8, len(before))
    _, speeds, outcome = collided(before, velocities, masses)
    change = masses[:, None] * (speeds - velocities)
    assert outcome.change.any(axis=1).sum() > 100
    assert np.linalg.norm(change.sum(0)) < 1e-10 * np.abs(change).sum()


@pytest.mark.parametrize("sideways", [0.05, 20.0])
def test_friction_is_within_the_cone_and_does_not_reverse(sideways):
    before, _ = cross(2e-3)
    before[:2, 0] = [-1.0, 1.0]
    velocities = np.outer([1, 1, 0, 0], [sideways, -1.0, 0.0])
    _, speeds, outcome = collided(before, velocities)
    assert outcome.found == 1
    change = (speeds - velocities)[:2].mean(0) - (speeds - velocities)[2:].mean(0)
    assert 0 < -change[0] <= LAW.friction * change[1] * (1 + 1e-6)
    assert -change[0] <= sideways * (1 + 1e-9)


def test_held_points_do_not_move():
    before, velocities = throw(100, 4)
    masses = np.full(len(before), 4e-8)
    masses[::4] = np.inf
    _, speeds, outcome = collided(before, velocities, masses)
    assert (speeds[::4] == velocities[::4]).all() and not outcome.change[::4].any()
    assert outcome.left == 0


def test_hair_that_is_already_tangled_stays_in_bounds():
    """A dense cloud in which hundreds of crossings share points, started again and again."""
    before, velocities = thrown(200, 0.01, 0.01, 1.0, 9)
    fastest = np.abs(velocities).max()
    for _ in range(5):
        before, velocities, _ = collided(before, velocities, law=Collisions(Thickness(3e-4)))
        assert np.isfinite(before).all() and np.abs(velocities).max() < 3 * fastest


def test_threads_do_not_matter(same_on_threads):
    before, velocities = thrown(200, 0.02, 0.01, 0.3, 8)
    _, _, outcome = same_on_threads(lambda: collided(before, velocities))
    assert outcome.found > 50


def test_ignored_pairs_pass():
    before, _ = cross(0.05)
    velocities = np.outer([1, 1, 0, 0], [0.0, -10.0, 0.0])
    offsets, ignored = np.array([0, 2, 4], np.int32), np.array([2], np.int64)
    outcome = collide(before, before + DT * velocities, np.full(4, 4e-8), offsets, DT, LAW, ignored)
    assert outcome.found == 0 and not outcome.change.any()
