"""Segments that pass through each other in a step are found, all of them and no others."""

import numpy as np
import pytest
from numba import njit

from hairpipe.contact.collision import crossings

LENGTH, SPEED, STEP = 3e-3, 10.0, 1 / 30


def directions(rng, *shape):
    v = rng.normal(size=(*shape, 3))
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def cross(before, after):
    """Crossings of pairs, (n, 4, 3): points a b c d."""
    count = len(before)
    pairs = (4 * np.arange(count)[:, None] + [0, 2]).astype(np.int32)
    found = crossings(before.reshape(-1, 3), after.reshape(-1, 3), pairs)
    return found, found.segments[:, 0] // 4


def places(before, after, time):
    """Where the lines cross, as fractions of both segments, and how far apart they are there."""
    a, b, c, d = np.moveaxis(before + time[:, None, None] * (after - before), 1, 0)
    u, v, w = b - a, d - c, a - c
    n = np.cross(u, v)
    nn = (n * n).sum(axis=1)
    s, t = -(np.cross(w, v) * n).sum(axis=1) / nn, -(np.cross(w, u) * n).sum(axis=1) / nn
    return s, t, np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1)


@njit
def volume(before, after, time):
    """Six times the volume that four points span at a time."""
    p = before + time * (after - before)
    u, v, w = p[1] - p[0], p[3] - p[2], p[2] - p[0]
    x, y, z = u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
    return x * w[0] + y * w[1] + z * w[2]


@njit
def sampled_roots(before, after, samples, roots):
    """Write the roots of the volume that many times tell, (n, 3), inf for none: halved again and again."""
    for k in range(len(before)):
        count, last = 0, volume(before[k], after[k], 0.0)
        for i in range(1, samples + 1):
            value = volume(before[k], after[k], i / samples)
            if (value < 0) != (last < 0):
                low, high = (i - 1) / samples, i / samples
                for _ in range(50):
                    middle = 0.5 * (low + high)
                    if (volume(before[k], after[k], middle) < 0) == (last < 0):
                        low = middle
                    else:
                        high = middle
                roots[k, count] = low
                count += 1
            last = value


def by_sampling(before, after):
    """First crossing of each pair, inf if there is none."""
    roots, first = np.full((len(before), 3), np.inf), np.full(len(before), np.inf)
    sampled_roots(before, after, 200, roots)
    which, number = np.nonzero(np.isfinite(roots))
    s, t, _ = places(before[which], after[which], roots[which, number])
    inside = (s > 0) & (s < 1) & (t > 0) & (t < 1)
    np.minimum.at(first, which[inside], roots[which, number][inside])
    return first


def test_of_random_motions_all_that_cross_and_no_others():
    rng = np.random.default_rng(1)
    before = LENGTH * rng.normal(size=(40_000, 4, 3))
    after = before + SPEED * STEP * directions(rng, 40_000, 4) * rng.random((40_000, 4, 1)) ** 3
    expected = by_sampling(before, after)
    found, which = cross(before, after)
    times = np.full(len(before), np.inf)
    times[which] = found.times
    # Sampling misses two roots between two samples: what it misses must be a crossing by its own measure.
    both = np.isfinite(expected)
    assert both.sum() > 2000
    assert (times[both] <= expected[both] + 1e-9).all()
    earlier = np.flatnonzero(times < expected - 1e-9)
    assert len(earlier) < 0.01 * both.sum()
    s, t, gap = places(before[earlier], after[earlier], times[earlier])
    assert (gap < 1e-8).all() and (np.minimum(s, t) > -1e-6).all() and (np.maximum(s, t) < 1 + 1e-6).all()


def test_none_is_missed_of_those_made_to_cross():
    """A hundred thousand that meet at a chosen time and place, at up to 10 m/s for 1/30 s, some nearly parallel."""
    rng = np.random.default_rng(2)
    count = 100_000
    time, s, t = rng.random((3, count, 1))
    u, v = LENGTH * directions(rng, 2, count)
    v[::4] = u[::4] * rng.uniform(-2, 2, (count // 4, 1)) + 10.0 ** rng.uniform(-8, -3, (count // 4, 1)) * v[::4]
    place = rng.random((count, 3))
    meeting = np.stack([place - s * u, place + (1 - s) * u, place - t * v, place + (1 - t) * v], axis=1)
    way = SPEED * STEP * directions(rng, count, 4) * rng.random((count, 4, 1))
    way[::2] = way[::2, :1] + 0.01 * way[::2]
    before, after = meeting - time[:, None] * way, meeting + (1 - time)[:, None] * way
    found, which = cross(before, after)
    assert len(which) == count
    assert (found.times <= time[:, 0] + 1e-6).all()
    ends = before + found.times[:, None, None] * (after - before)
    s, t = found.fractions.T[:, :, None]
    first, second = (1 - s) * ends[:, 0] + s * ends[:, 1], (1 - t) * ends[:, 2] + t * ends[:, 3]
    sizes = np.linalg.norm(ends[:, [1, 3]] - ends[:, [0, 2]], axis=2).sum(axis=1)
    assert (np.linalg.norm(first - second, axis=1) < 1e-4 * sizes + 1e-12).all()
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1, atol=1e-12)


def test_normals_point_to_where_the_first_came_from():
    rng = np.random.default_rng(3)
    count = 2000
    u, v = LENGTH * directions(rng, 2, count)
    n = np.cross(u, v)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    side = rng.choice([-1.0, 1.0], (count, 1))
    meeting = np.stack([-0.5 * u, 0.5 * u, -0.5 * v, 0.5 * v], axis=1)
    away = np.zeros_like(meeting)
    away[:, :2] = 0.01 * (side * n)[:, None]
    found, which = cross(meeting + away, meeting - away)
    assert len(which) == count
    np.testing.assert_allclose(found.normals, side * n, atol=1e-9)
    np.testing.assert_allclose(found.times, 0.5, atol=1e-12)
    np.testing.assert_allclose(found.fractions, 0.5, atol=1e-9)


def one(before, after):
    return cross(np.array([before], float), np.array([after], float))[0]


CROSS = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]], float)
UP = np.array([[0, 0, 1], [0, 0, 1], [0, 0, 0], [0, 0, 0]], float)


def test_resting_and_receding_pairs_do_not_cross():
    assert len(one(CROSS + UP, CROSS + UP).times) == 0
    assert len(one(CROSS + 1e-3 * UP, CROSS + UP).times) == 0
    assert len(one(CROSS + UP, CROSS + 1e-3 * UP).times) == 0
    assert len(one(CROSS + UP + 5, CROSS + UP - 7).times) == 0


def test_a_pair_that_touches_at_the_start_is_reported_at_once():
    for way in (-1.0, 0.0, 1.0):
        found = one(CROSS, CROSS + way * UP)
        assert found.times == pytest.approx([0.0])
        assert np.abs(found.normals[0]) == pytest.approx([0, 0, 1])
    assert one(CROSS + UP, CROSS).times == pytest.approx([1.0])


def test_touching_and_going_back_on_a_curved_path():
    """The first turns so that the lines meet at half time and part again: a double root."""
    before = CROSS + 0.25 * UP
    before[2:] += [[0, 0, 0.5], [0, 0, -0.5]]
    after = CROSS + 0.25 * UP
    after[2:] -= [[0, 0, 0.5], [0, 0, -0.5]]
    found = one(before - 0.25 * UP, after - 0.25 * UP)
    assert found.times[0] <= 0.5


@pytest.mark.parametrize("shift", [0.0, 0.7, -1.3])
@pytest.mark.parametrize("turn", [0.0, 1e-15, 1e-9, 1e-7])
def test_parallel_ones_pass_through_each_other_sideways(shift, turn):
    u = np.array([0.3, 0.5, 0.7])
    n = np.array([0.5, -0.3, 0.0])
    lies = np.array([-u, u, (shift - 1) * u, (shift + 1) * u])
    lies[2:] += turn * np.cross(u, n) * [[-1], [1]]
    away = np.array([n, n, 0 * n, 0 * n])
    found = one(lies + away, lies - 2 * away)
    assert found.times == pytest.approx([1 / 3], abs=1e-5)
    assert abs(found.normals[0] @ n) / np.linalg.norm(n) > 0.9 or turn > 1e-8
    assert len(one(lies + away, lies + 0.5 * away).times) == 0
    apart = lies + np.array([3 * u, 3 * u, 0 * u, 0 * u])
    assert len(one(apart + away, apart - away).times) == 0


def test_motion_within_a_plane_is_not_a_crossing():
    """An end comes first: what the paper leaves to nobody. Where one lies across the other in the end they touch."""
    up = np.array([0.0, 3.0, 0.0])
    apart, beyond = CROSS + np.array([0 * up, 0 * up, up, up]), CROSS - np.array([0 * up, 0 * up, up, up])
    assert len(one(apart, beyond).times) == 0
    assert len(one(apart, apart - [1.0, 0.5, 0.0]).times) == 0
    assert one(apart, CROSS).times == pytest.approx([1.0])


def test_an_edge_that_passes_through_a_joint_is_caught():
    """By at least one of the two segments that the joint belongs to, however it is rounded."""
    rng = np.random.default_rng(5)
    for _ in range(300):
        joint, u, v, w, way = rng.normal(size=(5, 3))
        missed = 0
        for side in (v, w):
            meeting = np.array([joint - 0.4 * u, joint + 0.6 * u, joint, joint + side])
            away = np.array([way, way, 0 * way, 0 * way])
            missed += len(one(meeting + 0.3 * away, meeting - 0.7 * away).times) == 0
        assert missed < 2


def test_threads_do_not_matter(same_on_threads):
    before, after = np.random.default_rng(7).normal(size=(2, 3000, 4, 3))
    same_on_threads(lambda: cross(before, after)[0])
