"""Which hairs form a lock, what they inherit, and how locks are audited."""

import numpy as np
import pytest

from hairpipe.contact.stiction import Connections
from hairpipe.laws.settings import Locks
from hairpipe.shot.lock_guides import guides_of, joined
from hairpipe.shot.locks import about_roots, audited_locks, back_in, inherited, moved_since, to_audit

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


FOUR = np.arange(0, 21, 5, dtype=np.int32)
FOLLOWING = np.array([2, 1, 2, 3], np.int32)
"""Strand 0 follows strand 2 from now on."""


def test_inherited_connections_keep_place_and_age():
    connections = Connections(
        np.array([[1, 7], [3, 13], [6, 18]], np.int32), np.array([[0.1, 0.9], [0.5, 0.5], [0.3, 0.4]])
    )
    found, ages = inherited(connections, np.array([5, 6, 7]), FOLLOWING, FOUR, 5)
    # 1 - 7 is now 11 - 7, the lower first; what tied 0 to 2 has ended; 6 - 18 is as it was.
    np.testing.assert_array_equal(found.segments, [[6, 18], [7, 11]])
    np.testing.assert_array_equal(found.fractions, [[0.3, 0.4], [0.9, 0.1]])
    np.testing.assert_array_equal(ages, [7, 5])


def test_a_segment_has_no_more_than_it_may_and_its_own_come_first():
    connections = Connections(np.array([[1, 5], [1, 6], [7, 11]], np.int32), np.full((3, 2), 0.5))
    for closest, expected in ((1, [[7, 11]]), (2, [[6, 11], [7, 11]]), (3, [[5, 11], [6, 11], [7, 11]])):
        found, _ = inherited(connections, np.array([1, 8, 0]), FOLLOWING, FOUR, closest)
        np.testing.assert_array_equal(found.segments, expected)


def test_nothing_changes_where_all_lead_themselves():
    connections = Connections(np.array([[1, 7], [3, 13]], np.int32), np.array([[0.1, 0.9], [0.5, 0.5]]))
    found, ages = inherited(connections, np.array([2, 3]), np.arange(4, dtype=np.int32), FOUR, 5)
    np.testing.assert_array_equal(found.segments, connections.segments)
    np.testing.assert_array_equal(found.fractions, connections.fractions)
    np.testing.assert_array_equal(ages, [2, 3])


LEADERS = np.array([0, 0, 2, 2, 2, 5, 6, 6, 6, 9, 9, 11, 11], np.int32)
"""Five locks, with one to two hairs that follow, and a hair alone."""


@pytest.mark.parametrize("share", [0.05, 0.25, 0.5, 1.0])
def test_each_lock_is_audited_once_in_as_many_turns_as_the_share_says(share):
    leaders, turns = np.concatenate([LEADERS + len(LEADERS) * k for k in range(12)]), round(1 / share)
    chosen = [to_audit(leaders, share, turn) for turn in range(7, 7 + turns)]
    follows = leaders != np.arange(len(leaders))
    np.testing.assert_array_equal(sum(audited.astype(int) for audited in chosen), follows)
    for audited in chosen:
        np.testing.assert_array_equal(audited, follows & np.isin(leaders, leaders[audited]))  # with all its hairs


def test_two_of_eight_locks_are_audited_however_small_the_share():
    leaders = np.repeat(np.arange(0, 16, 2), 2)
    for turn in range(9):
        assert to_audit(leaders, 0.02, turn).sum() == 2


def test_without_a_share_nothing_is_audited():
    assert not to_audit(LEADERS, 0.0, 3).any()


def test_the_error_of_a_lock_is_the_rms_of_its_hairs():
    audit, locks = audited_locks(np.array([5, 2, 2], np.int32), np.array([3.0, 1.0, 7.0]))
    np.testing.assert_allclose(audit.errors, [5.0, 3.0])
    np.testing.assert_array_equal(audit.hairs, [2, 1])
    np.testing.assert_array_equal(locks, [1, 0, 0])


def test_hair_on_trial_follows_the_nearest_guide_with_room_or_becomes_a_guide():
    leaders = np.array([0, 0, 2, 3, 4, 5, 6], np.int32)
    nearest = np.array([[0, 6], [0, 6], [0, 4], [6, 0], [6, 6]])
    for tried, most, then, leading in (
        ([2, 4, 5], 16, [0, 0, 0, 3, 0, 6, 6], []),
        ([2, 5], 16, [0, 0, 0, 3, 4, 6, 6], []),
        ([2, 4, 5], 3, [0, 0, 0, 3, 4, 6, 6], [4]),
        ([2, 3, 4, 5], 2, [0, 0, 6, 3, 4, 5, 6], [3, 5]),
        ([6], 16, leaders, []),  # no guide near it
        ([], 16, leaders, []),
    ):
        tried = np.array(tried, np.int64)
        after, guides = back_in(leaders, tried, nearest[tried - 2], most)
        np.testing.assert_array_equal(after, then)
        np.testing.assert_array_equal(guides, leading)


def test_hair_that_moves_rigidly_with_its_root_has_not_moved():
    offsets, points = np.array([0, 3, 5]), np.random.default_rng(2).random((5, 3))
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    still = np.tile(np.eye(3, 4), (2, 1, 1))
    moved = np.tile(np.concatenate([turn, [[0.3], [2.0], [-0.4]]], axis=1), (2, 1, 1))
    there = points @ turn.T + [0.3, 2.0, -0.4]
    np.testing.assert_allclose(about_roots(there, offsets, moved), about_roots(points, offsets, still), atol=1e-6)


def test_hair_that_creeps_is_found_once_it_has_moved_by_more_than_the_tolerance():
    offsets, first = np.array([0, 2, 4]), np.zeros((4, 3), np.float32)
    reference, found = first, []
    for turn in range(1, 8):
        here = first.copy()
        here[2:, 0] = 0.4 * turn  # the second hair
        moved, reference = moved_since(reference, here, offsets, 1.0)
        found.append(moved.tolist())
    assert [turn for turn, moved in enumerate(found, 1) if moved != [False, False]] == [3, 6]
    assert found[2] == found[5] == [False, True]
