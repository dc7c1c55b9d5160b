"""What is told of a trial, where the answer is known."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.integrators.errors import error_table
from hairpipe.graphs.experiments.studies.integrators.extremes import extremes_table
from hairpipe.graphs.experiments.studies.integrators.follow import follow
from hairpipe.graphs.experiments.studies.integrators.record import course_of, course_table
from hairpipe.graphs.experiments.studies.integrators.trial import Trial
from hairpipe.laws.settings import Scheme

SHORT = Trial(("rest", "swing", "shake 600 deg/s"), lengths=(0.1, 0.05), segments=5, seconds=0.125)


@pytest.fixture(scope="module")
def truth():
    return course_table(SHORT, Scheme(), None, 1920)


def test_energy_is_that_above_hanging_and_never_grows():
    """A straight strand at angle a holds (1 - cos a) / 2 of m g L; a bent one holds some in its altitude springs."""
    course = follow(SHORT, Scheme(), None, 1 / 1920)
    np.testing.assert_allclose(course.energy[0], [0, 0, 0.25, 0.25, 0, 0], atol=1e-12)
    np.testing.assert_allclose(course.energy[-1, :2], 0, atol=1e-4)
    assert (course.energy[:, 2:4] < 0.25 + 1e-3).all() and (course.energy[-1, 2:4] > 0.25 - 0.1).all()
    assert (course.kinetic[1:, 2:] > course.kinetic[1:, :2].max()).all()


def test_a_rod_turns_weight_into_motion_and_bending_and_loses_nothing_but_to_the_air():
    """What is missing after an eighth of a second is what drag takes, 2 c times the kinetic energy in each second."""
    trial = Trial(("swing",), lengths=(0.05,), segments=5, seconds=0.125, model="rod")
    course = follow(trial, Scheme(), None, 1 / 1920)
    np.testing.assert_allclose(course.energy[0], 0.25, atol=1e-12)
    lost = course.energy[0, 0] - course.energy[-1, 0]
    assert 0.0 < lost < 2 * 0.1 * 0.125 * course.kinetic.max()
    assert course.kinetic.max() > 0.015


def test_strand_is_the_same_alone_and_among_others(truth):
    alone = Trial(("swing",), lengths=(0.05,), segments=5, seconds=0.125)
    together = course_of(truth, SHORT)
    np.testing.assert_array_equal(follow(alone, Scheme(), None, 1 / 1920).tips[:, 0], together.tips[:, 3])


def test_equal_steps_have_no_error_and_unstable_schemes_are_reported(truth):
    same = error_table(truth, SHORT, Scheme(), None, [1920], 1e6)
    assert not same["tip error [% of length]"].any() and set(same["failed"]) == {""}
    explicit = Scheme("backward_euler", "explicit")
    assert set(error_table(truth, SHORT, explicit, None, [240], 1e6)["failed"]) == {"stretch, energy"}
    assert set(error_table(truth, SHORT, explicit, None, [240], 10)["failed"]) == {"not run"}


def test_a_converged_run_of_another_trial_is_refused(truth):
    with pytest.raises(BadInput, match="another trial"):
        error_table(truth, Trial(seconds=0.125), Scheme(), None, [24], 1e6)


def test_the_oddest_strands_stay_finite_at_one_step_a_frame():
    table = extremes_table([24], 2.0)
    assert set(table["outcome"]) == {"comes back"}
