"""Hair between bodies that leave it less room than it wants, and what points remember of bodies."""

import numpy as np
import pytest

from hairpipe.contact.body import ProbeCache, share_gap
from hairpipe.geometry.collider import SdfSample

from ...strand_scenes import Solid

THICK = 1e-3


def plate(height, up):
    """A half space below or above a height [m] that does not move."""
    return Solid(lambda x, _: (up * (x[:, 1] - height), [0.0, up, 0.0]), swept=False)


def settle(gap, start, kept, rounds=50):
    """Where points end that are moved out of the nearest of two plates, again and again, (P,) [m]."""
    plates = [plate(0.0, 1.0), plate(gap, -1.0)]
    points = np.column_stack([0 * start, start, 0 * start])
    thickness = np.full(len(start), THICK)
    for _ in range(rounds):
        probe = SdfSample.blank(len(points), 0.1)
        for one in plates:
            one.probe(points, 0.0, probe)
        room = share_gap(points, 0.0, plates, probe, thickness, kept)
        points[:, 1] += np.maximum(room - probe.distance, 0.0) * probe.normal[:, 1]
    return points[:, 1]


@pytest.mark.parametrize("gap", [1.5e-3, 0.5e-3, 0.0, -1e-3])
def test_points_come_to_rest_in_the_middle(gap):
    start = np.linspace(min(0.0, gap) - 1e-3, max(0.0, gap) + 1e-3, 9)
    ends = settle(gap, start, np.full(9, THICK))
    np.testing.assert_allclose(ends, 0.5 * gap, atol=1.01e-4)


def test_where_there_is_room_nothing_changes():
    points = np.array([[0.0, y, 0.0] for y in (-2e-3, 2e-4, 1e-3, 9.5e-3, 5e-3)])
    plates, kept = [plate(0.0, 1.0), plate(1e-2, -1.0)], np.full(5, THICK)
    probe = SdfSample.blank(5, 0.1)
    for one in plates:
        one.probe(points, 0.0, probe)
    np.testing.assert_array_equal(share_gap(points, 0.0, plates, probe, kept, kept), kept)


def test_points_that_keep_more_from_one_side_share_the_room():
    """Two heights of a curl over the lower plate keep their order under the upper one."""
    ends = settle(3e-3, np.array([0.5e-3, 0.6e-3]), np.array([1.5e-3, 3e-3]), rounds=1)
    assert 0.0 < ends[0] < ends[1] < 3e-3
    np.testing.assert_allclose(ends[1], 3e-3 * 3.0 / 4.0)


def test_held_roots_inside_a_body_are_accepted():
    points, nothing = np.array([[0.0, -1e-3, 0.0]]), np.zeros(1)
    plates = [plate(0.0, 1.0), plate(-1e-4, -1.0)]
    probe = SdfSample.blank(1, 0.1)
    for one in plates:
        one.probe(points, 0.0, probe)
    assert np.isfinite(share_gap(points, 0.0, plates, probe, nothing, nothing)).all()


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

    def approach(self, wander, out):
        gone = (wander.after - wander.before)[wander.which] - [wander.now - wander.then, 0.0, 0.0]
        out[:] = np.maximum(out, np.linalg.norm(gone, axis=1))


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


def test_many_far_points_that_move_with_the_body_are_probed_once(around):
    points, bound = np.repeat(around[0], 3, axis=0), np.repeat(around[1], 3)
    ball, everyone = Ball(), np.ones(len(points), bool)
    cache = ProbeCache([ball], len(points), REACH, FAR)
    for k in range(6):
        moved = points + np.array([0.2 * k, 0.0, 0.0])
        cache.renew(moved, 0.2 * k, everyone, bound)
        assert_same_where_it_matters(cache, moved, 0.2 * k, bound)
    close = bound | (np.linalg.norm(points, axis=1) - 1.0 <= FAR)
    assert ball.looks == len(points) + 5 * close.sum()


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
