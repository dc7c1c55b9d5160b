"""Which hairs form a lock: those with most lasting connections first, none larger than allowed."""

import numpy as np

from hairpipe.laws.settings import Locks
from hairpipe.shot.lock_guides import guides_of, joined

OFFSETS = np.arange(0, 31, 5, dtype=np.int32)
"""Of six strands of four segments."""


def ties(*pairs):
    """Connections between strands, so many of each: (a, b, count); sorted as connections are."""
    segments = [(5 * a + k, 5 * b + k) for a, b, count in pairs for k in range(count)]
    return np.array(sorted(segments), np.int32).reshape(-1, 2)


def lead(segments, ages=None, leaders=None, occupancy=None, **settings):
    leaders = np.arange(6, dtype=np.int32) if leaders is None else leaders
    ages = np.full(len(segments), 9) if ages is None else ages
    return joined(leaders, leaders if occupancy is None else occupancy, segments, ages, OFFSETS, Locks(**settings))


def test_those_with_enough_that_lasted_are_joined():
    segments = ties((0, 1, 2), (2, 3, 1), (4, 5, 2))
    ages = np.where(segments[:, 0] >= 20, 3, 5)
    np.testing.assert_array_equal(lead(segments, ages), [0, 0, 2, 3, 4, 5])


def test_most_connections_come_first_and_no_lock_is_larger_than_allowed():
    segments = ties((0, 1, 2), (1, 2, 3), (2, 3, 4))
    np.testing.assert_array_equal(lead(segments, most=2), [0, 0, 2, 2, 4, 5])
    np.testing.assert_array_equal(lead(segments, most=3), [0, 1, 1, 1, 4, 5])
    np.testing.assert_array_equal(lead(segments, most=4), [0, 0, 0, 0, 4, 5])


def test_followers_count_and_stay_in_their_lock():
    leaders = np.array([0, 0, 2, 2, 4, 5], np.int32)
    np.testing.assert_array_equal(lead(ties((0, 2, 3)), leaders=leaders, most=4), [0, 0, 0, 0, 4, 5])
    np.testing.assert_array_equal(lead(ties((0, 2, 3)), leaders=leaders, most=3), leaders)


def test_hairs_that_will_follow_again_keep_their_seats():
    occupancy = np.array([0, 1, 2, 3, 0, 0], np.int32)
    np.testing.assert_array_equal(lead(ties((0, 1, 3)), occupancy=occupancy, most=4), [0, 0, 2, 3, 4, 5])
    np.testing.assert_array_equal(lead(ties((0, 1, 3)), occupancy=occupancy, most=3), [0, 1, 2, 3, 4, 5])


def test_guide_is_nearest_to_the_mean_of_its_lock():
    points = np.zeros((30, 3))
    points[:, 0] = np.repeat([0.0, 1.0, 2.0, 9.0, 7.0, 5.0], 5)
    leaders = np.array([0, 1, 2, 3, 4, 0], np.int32)  # strand 5 follows 0, and pulls the mean towards itself: 2.0
    locks = np.array([0, 0, 0, 3, 4, 0], np.int32)
    np.testing.assert_array_equal(guides_of(locks, leaders, points, OFFSETS), [2, 2, 2, 3, 4, 2])
