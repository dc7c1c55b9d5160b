"""Whom hair follows: the nearest keys on its own side."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.groom.key_weights import keys_among, weigh_keys
from hairpipe.groom.strands import lay_strands
from hairpipe.values.strand_arrays import take


def scattered(count, seed):
    """Straight hairs with roots at random in a square of a metre, that go to either side of x = 0."""
    groom = lay_strands(count, 0.1, 3, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), None, 0.0)
    rng = np.random.default_rng(seed)
    roots = np.repeat(rng.uniform(-0.5, 0.5, (count, 3)) * (1.0, 1.0, 0.0), 4, axis=0)
    points = groom.points * np.where(roots[:, :1] > 0.0, 1.0, -1.0) + roots
    return replace(groom, points=points, ids=groom.ids + 1000 * seed)


def test_weights_are_those_of_brute_force():
    keys, groom = scattered(40, 1), scattered(100, 2)
    found = weigh_keys(keys, groom, 60.0)
    for s in range(100):
        root = groom.points[4 * s]
        others = keys.points[::4]
        same_side = (others[:, 0] > 0.0) == (root[0] > 0.0)
        distances = np.where(same_side, np.linalg.norm(others - root, axis=1), np.inf)
        nearest = np.argsort(distances)[:3]
        weights = distances[nearest] ** -2.0
        assert np.array_equal(found.keys[s], nearest)
        assert found.weights[s] == pytest.approx(weights / weights.sum(), rel=1e-9)


def test_keys_across_a_parting_are_not_followed(at, bent, shown):
    keys, groom = scattered(40, 1), scattered(100, 2)
    left = keys.points[keys.offsets[:-1], 0] < 0.0
    hair = np.where(np.repeat(left, 4)[:, None], bent(keys, 90.0, 3), keys.points)
    found = shown(at(keys, hair), keys, groom)
    right = np.repeat(groom.points[groom.offsets[:-1], 0] > 0.0, 4)
    assert found.points[right] == pytest.approx(groom.points[right], abs=1e-14)
    assert np.abs(found.points - groom.points)[~right].max() > 0.01
    beyond = shown(at(keys, hair), keys, groom, parting=180.0)
    assert np.abs(beyond.points - groom.points)[right].max() > 0.01


def test_hair_that_is_like_no_key_follows_the_one_least_unlike(row):
    up = replace(row, points=row.points * (1.0, -1.0, 1.0), ids=row.ids + 9)
    keys = replace(row, points=row.points.copy())
    keys.points[keys.offsets[2] + 1 : keys.offsets[3]] += (0.05, 0.0, 0.0)
    assert np.array_equal(weigh_keys(keys, up, 60.0).keys[:, 0], [2, 2, 2, 2])


def test_keys_that_share_a_root_are_themselves(row):
    fan = replace(row, points=row.points + 0.01 * np.random.default_rng(4).normal(size=row.points.shape))
    fan.points[fan.offsets[:-1]] = 0.0
    assert np.array_equal(weigh_keys(fan, fan, 60.0).own, np.arange(4))


def test_a_key_is_known_by_its_id_and_its_points(row):
    some = take(row, np.array([3, 0]))
    assert np.array_equal(keys_among(row, some), [1, -1, -1, 0])
    assert np.array_equal(keys_among(row, replace(some, ids=np.array([0, 3]))), [-1, -1, -1, -1])
    assert np.array_equal(weigh_keys(replace(some, ids=some.ids + 9), row, 60.0).homes, [3, 0])


def test_one_key_is_followed_by_all(row):
    found = weigh_keys(take(row, np.array([2])), row, 60.0)
    assert np.array_equal(found.keys[:, 0], [0, 0, 0, 0])
    assert np.array_equal(found.weights, [[1.0, 0.0, 0.0]] * 4)
