"""Of every segment the closest few are found, and kept are those that agree on it."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.proximity import closest_pairs, near_pairs
from hairpipe.geometry.segment_distance import closest_of
from hairpipe.geometry.segments import key_of


@njit
def _squared_distances(points, pairs, out):
    for k in range(len(pairs)):
        out[k] = closest_of(points, pairs[k, 0], pairs[k, 1])[2]


def closest(points, pairs, most, room=None):
    """Of all pairs."""
    return closest_pairs(points, pairs, np.ones(len(pairs.distances), bool), most, room)


def chosen_among(points, pairs, limits):
    """Sort all that is near by distance, then number, and keep the pairs that are in both lists."""
    pairs = pairs[(limits[pairs] > 0).all(axis=1)]
    squared, lists = np.empty(len(pairs)), {}
    _squared_distances(points, pairs, squared)
    for (i, j), d in zip(pairs.tolist(), squared.tolist(), strict=True):
        lists.setdefault(i, []).append((d, j))
        lists.setdefault(j, []).append((d, i))
    lists = {i: {j for _, j in sorted(near)[: limits[i]]} for i, near in lists.items()}
    return [[i, j] for i, j in pairs.tolist() if j in lists[i] and i in lists[j]]


@pytest.mark.parametrize("most", [1, 5])
def test_the_closest_of_both(scene, most):
    points, offsets, reach = scene
    expected = chosen_among(points, near_pairs(points, offsets, reach).segments, np.full(len(points), most))
    found = closest(points, near_pairs(points, offsets, reach), most)
    assert found.segments.tolist() == expected
    assert np.bincount(found.segments.ravel()).max() <= most


def test_room_that_is_left(scene):
    points, offsets, reach = scene
    room = np.random.default_rng(6).integers(0, 7, len(points))
    expected = chosen_among(points, near_pairs(points, offsets, reach).segments, np.minimum(room, 4))
    found = closest(points, near_pairs(points, offsets, reach), 4, room)
    assert found.segments.tolist() == expected
    assert (np.bincount(found.segments.ravel(), minlength=len(points)) <= room).all()


def test_ignored_segments_take_no_place(scene):
    points, offsets, reach = scene
    ignored = key_of(closest(points, near_pairs(points, offsets, reach), 2).segments)
    others = near_pairs(points, offsets, reach, ignored)
    found = closest(points, others, 2)
    assert found.segments.tolist() == chosen_among(points, others.segments, np.full(len(points), 2))


def test_threads_do_not_matter(hair, threads):
    points, _, offsets = hair
    runs = []
    for count in (1, 2):
        threads(count)
        runs.append(closest(points, near_pairs(points, offsets, 5e-3), 3))
    assert len(runs[0].distances) > 1000
    for one, other in zip(*runs, strict=True):
        np.testing.assert_array_equal(one, other)


def test_limits_of_zero_give_no_pairs(scene):
    points, offsets, reach = scene
    near = near_pairs(points, offsets, reach)
    assert len(closest(points, near, 5, np.zeros(len(points), int)).distances) == 0
