"""What points remember of bodies is what they would see if they looked."""

import numpy as np
import pytest

from hairpipe.contact.body import ProbeCache
from hairpipe.geometry.collider import SdfSample

REACH, FAR = 0.3, 0.1


class Ball:
    """Of radius 1, moving along x at 1 m/s; counts the points that look."""

    speed, band = 1.0, np.inf

    def __init__(self):
        self.looks = 0

    def probe(self, points, seconds, out, reach=None):
        self.looks += len(points)
        way = points - [seconds, 0.0, 0.0]
        length = np.linalg.norm(way, axis=1)
        near = length - 1.0 < out.distance
        out.distance[near] = (length - 1.0)[near]
        near &= length - 1.0 < (np.inf if reach is None else reach)
        out.normal[near] = (way / length[:, None])[near]
        out.velocity[near] = [1.0, 0.0, 0.0]


@pytest.fixture
def around():
    """Points within half a radius of the surface, which of them touch, and random numbers."""
    rng = np.random.default_rng(4)
    way = rng.normal(size=(2000, 3))
    points = way / np.linalg.norm(way, axis=1)[:, None] * rng.uniform(0.5, 1.5, (2000, 1))
    return points, rng.random(2000) < 0.2, rng


def fresh(points, time):
    probe = SdfSample.blank(len(points))
    Ball().probe(points, time, probe, np.full(len(points), REACH))
    return probe


def assert_same_where_it_matters(cache, points, time, bound):
    truth = fresh(points, time)
    near = bound | (truth.distance <= FAR)
    for seen, is_there in zip(cache.probe, truth, strict=True):
        np.testing.assert_array_equal(seen[near], is_there[near])
    assert (cache.probe.distance[~near] > FAR).all()


@pytest.mark.parametrize("step", [0.0, 1e-3, 0.03, 0.3])
def test_points_that_wander_see_what_there_is(around, step):
    points, bound, rng = around
    ball, everyone = Ball(), np.ones(len(points), bool)
    cache = ProbeCache([ball], len(points), REACH, FAR)
    for time in (0.0, 0.0, 0.0, 0.0, 0.7, 0.7):
        cache.renew(points, time, everyone, bound)
        assert_same_where_it_matters(cache, points, time, bound)
        points = points + step * rng.normal(size=points.shape)
    assert ball.looks == 2 * len(points) if step == 0.0 else 2 * len(points) < ball.looks <= 6 * len(points)


def test_far_points_are_not_probed_at_later_times(around):
    points, bound, _ = around
    ball, everyone = Ball(), np.ones(len(points), bool)
    cache = ProbeCache([ball], len(points), REACH, FAR)
    for k in range(6):
        cache.renew(points, 0.02 * k, everyone, bound)
        assert_same_where_it_matters(cache, points, 0.02 * k, bound)
        truth = np.linalg.norm(points - [0.02 * k, 0.0, 0.0], axis=1) - 1.0
        assert (cache.clearance <= truth).all()
        np.testing.assert_array_equal(cache.clearance[truth <= FAR], truth[truth <= FAR])
    assert 4 * len(points) < ball.looks < 5 * len(points)


def test_many_small_ways_are_not_taken_for_none(around):
    points, bound, _ = around
    cache, everyone = ProbeCache([Ball()], len(points), REACH, FAR), np.ones(len(points), bool)
    inwards = points / np.linalg.norm(points, axis=1)[:, None]
    for k in range(100):
        cache.renew(points - 1e-2 * k * inwards, 0.0, everyone, bound)
        assert_same_where_it_matters(cache, points - 1e-2 * k * inwards, 0.0, bound)


def test_unprobed_points_keep_their_last_probe(around):
    points, bound, rng = around
    cache, everyone = ProbeCache([Ball()], len(points), REACH, FAR), np.ones(len(points), bool)
    cache.renew(points, 0.0, everyone, bound)
    before = cache.probe.distance.copy()
    some = rng.random(len(points)) < 0.5
    moved = points + 0.2
    cache.renew(moved, 0.5, some, bound)
    np.testing.assert_array_equal(cache.probe.distance[~some], before[~some])
    cache.renew(moved, 0.5, everyone, bound)
    assert_same_where_it_matters(cache, moved, 0.5, bound)


def test_points_that_are_lost_always_look(around):
    points, bound, _ = around
    ball, lost = Ball(), np.full_like(points[:3], np.nan)
    cache = ProbeCache([ball], 3, REACH, FAR)
    for _ in range(2):
        cache.renew(lost, 0.0, np.ones(3, bool), bound[:3])
    assert ball.looks == 6
