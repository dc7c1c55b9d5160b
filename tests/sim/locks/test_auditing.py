"""Locks are audited by turns, and go on by what their hairs are off by."""

import numpy as np
import pytest

from hairpipe.sim.locks.auditing import back_in, means_of_locks, passed, to_audit
from hairpipe.sim.locks.grouping import follows

LEADERS = np.array([0, 0, 2, 2, 2, 5, 6, 6, 6, 9, 9, 11, 11], np.int32)
"""Five locks, with one to two hairs that follow, and a hair alone."""


@pytest.mark.parametrize("share", [0.05, 0.25, 0.5, 1.0])
def test_each_lock_is_audited_once_in_as_many_turns_as_the_share_says(share):
    leaders, turns = np.concatenate([LEADERS + len(LEADERS) * k for k in range(12)]), round(1 / share)
    chosen = [to_audit(leaders, share, turn) for turn in range(7, 7 + turns)]
    np.testing.assert_array_equal(sum((guides >= 0).astype(int) for guides in chosen), follows(leaders))
    for guides in chosen:
        for guide in set(guides) - {-1}:
            np.testing.assert_array_equal(guides[follows(leaders) & (leaders == guide)], guide)  # with all its hairs


def test_two_of_eight_locks_are_audited_however_small_the_share():
    leaders = np.repeat(np.arange(0, 16, 2), 2)
    for turn in range(9):
        assert len(set(to_audit(leaders, 0.02, turn)) - {-1}) == 2


def test_without_a_share_nothing_is_audited():
    assert (to_audit(LEADERS, 0.0, 3) == -1).all()


def test_a_lock_goes_on_by_the_rms_of_its_hairs():
    guides = np.array([-1, 0, -1, 2, 2, -1], np.int32)
    errors = np.array([np.nan, 3.0, np.nan, 1.0, 7.0, np.nan])
    means, hairs = means_of_locks(guides, errors)
    np.testing.assert_allclose(means, [3.0, 5.0])
    np.testing.assert_array_equal(hairs, [1, 2])
    np.testing.assert_array_equal(passed(guides, errors, 4.0), [False, True, False, False, False, False])
    np.testing.assert_array_equal(passed(guides, errors, 5.0), guides >= 0)


def test_hair_on_trial_follows_the_nearest_guide_with_room_or_becomes_a_guide():
    leaders = np.array([0, 0, 2, 3, 4, 5, 6], np.int32)
    beside = np.full((7, 2), -1, np.int32)
    beside[2:6] = [[0, 6], [0, 6], [0, -1], [6, 0]]
    errors = np.array([np.nan, np.nan, 1.0, 9.0, 2.0, 0.5, 0.1])
    for tolerance, most, then, leading in (
        (4.0, 16, [0, 0, 0, 3, 0, 6, 6], []),
        (1.5, 16, [0, 0, 0, 3, 4, 6, 6], []),
        (4.0, 3, [0, 0, 0, 3, 4, 6, 6], [4]),
        (9.0, 2, [0, 0, 6, 3, 4, 5, 6], [3, 5]),
        (0.2, 16, leaders, []),
    ):
        after, guides = back_in(leaders, beside, errors, tolerance, most)
        np.testing.assert_array_equal(after, then)
        np.testing.assert_array_equal(guides, leading)
