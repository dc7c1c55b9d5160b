"""Locks are audited by turns, and go on by what their hairs are off by."""

import numpy as np
import pytest

from hairpipe.sim.locks.auditing import means_of_locks, passed, to_audit

LEADERS = np.array([0, 0, 2, 2, 2, 5, 6, 6, 6, 9, 9, 11, 11], np.int32)
"""Five locks, with one to two hairs that follow, and a hair alone."""


@pytest.mark.parametrize("share", [0.02, 0.25, 0.5, 1.0])
def test_each_lock_is_audited_once_in_as_many_turns_as_the_share_says(share):
    turns = round(1 / share)
    times = sum((to_audit(LEADERS, share, turn) >= 0).astype(int) for turn in range(7, 7 + turns))
    np.testing.assert_array_equal(times, np.arange(len(LEADERS)) != LEADERS)
    for turn in range(turns):
        chosen = to_audit(LEADERS, share, turn)
        for guide in set(chosen) - {-1}:
            np.testing.assert_array_equal(chosen[guide == LEADERS][1:], guide)  # with all its hairs


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
