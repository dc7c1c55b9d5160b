"""Locks are audited by turns, and go on by what their hairs are off by."""

import numpy as np
import pytest

from hairpipe.shot.locks import about_roots, audited_locks, back_in, moved_since, to_audit

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
