"""What studies of integrators measure, where the answer is known."""

import numpy as np
import pytest
from numba import njit

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.measure_rates import measure_rates
from hairpipe.graphs.experiments.studies.contact.bar import tuft
from hairpipe.graphs.experiments.studies.integrators.cost import order_of, solves_for
from hairpipe.graphs.experiments.studies.integrators.energy import altitude_energies, energies
from hairpipe.graphs.experiments.studies.integrators.errors import error_table
from hairpipe.graphs.experiments.studies.integrators.extremes import extremes_table
from hairpipe.graphs.experiments.studies.integrators.follow import follow
from hairpipe.graphs.experiments.studies.integrators.record import course_of, course_table
from hairpipe.graphs.experiments.studies.integrators.trial import Trial
from hairpipe.groom.strands import lay_strands
from hairpipe.laws.settings import Scheme, StepControl
from hairpipe.solve.band import row_size
from hairpipe.solve.stage import Iterate, State, System
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.interface import Terms, add_forces
from hairpipe.strands.material import Material

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


@njit
def add_all(model, A, b, x, still):
    for p in range(x.shape[0]):
        add_forces(model, System(A, b), Iterate(x, still, still), p, 0, Terms(1.0, 0.0, 0.0, 0))


@pytest.mark.parametrize("seed", range(3))
def test_force_of_a_network_is_minus_the_gradient_of_its_springs_and_altitudes(seed):
    """Bent at random, so far that no choice of an altitude changes hands on the way."""
    hair = build_hair(tuft(), Material(), "network")
    model, rng, count = hair.model, np.random.default_rng(seed), int(hair.model.first[1])
    place = hair.rest + 3e-4 * rng.normal(size=hair.rest.shape)
    still, way = np.zeros_like(place[:count]), np.zeros_like(place)
    way[:count] = 1e-9 * rng.normal(size=still.shape)

    def energy(x):
        state = State(x, np.zeros_like(x), np.zeros_like(x), np.zeros_like(model.inverse_lengths), np.zeros(1, bool))
        return (energies(hair, state, 0.0) + altitude_energies(model, hair.layout, x))[0]

    force = np.zeros_like(still)
    add_all(model, np.zeros((count, row_size(model.shape), still.shape[2])), force, place[:count].copy(), still)
    done = 2.0 * np.einsum("pcl,pcl->l", force, way[:count])
    assert energy(place - way) - energy(place + way) == pytest.approx(done, rel=1e-4, abs=1e-5 * np.abs(done).max())


STEPS = 0.1 * 0.5 ** np.arange(6.0)


def test_order_is_that_of_the_power_whatever_lies_beyond_it():
    errors = 1000 * STEPS**2
    assert order_of(STEPS, errors) == pytest.approx(2.0)
    lost, rounded = errors.copy(), errors.copy()
    lost[0], rounded[-1] = 60.0, 0.009
    assert order_of(STEPS, lost) == pytest.approx(2.0)
    assert order_of(STEPS[:5], rounded[:5]) == pytest.approx(2.0)
    assert np.isnan(order_of(STEPS[:2], errors[:2]))


def test_solves_are_interpolated_where_the_error_falls_below_a_level_for_good():
    solves, errors = 2 / STEPS, 1000 * STEPS**2
    assert solves_for(1.0, solves, errors) == pytest.approx(2 / np.sqrt(1e-3))
    assert solves_for(20.0, solves, errors) == solves[0]
    assert np.isnan(solves_for(1e-3, solves, errors))
    humped = np.array([0.5, 40.0, 4.0, 0.4, 0.04, 0.004])
    assert solves[2] < solves_for(1.0, solves, humped) < solves[3]
    humped[2] = np.nan
    assert solves_for(1.0, solves, humped) == solves[3]


def test_cost_without_runs_is_unknown():
    assert np.isnan(solves_for(1.0, np.array([]), np.array([])))


GROOM = lay_strands(9, 0.05, 4, (1.0, -0.3, 0.0), (0.0, 0.0, 0.01), None, 0.0)
EQUAL, LARGEST = StepControl(1 / 96), StepControl(1.0)


def differences(steps, finer=1):
    settings = {"model": "network", "precision": "double", "every": 0.25, "intervals": 1}
    table = measure_rates(GROOM, None, rates=(24, 48), steps=steps, finer=finer, **settings)
    assert table["time [s]"].tolist() == [0.25, 0.25]
    return table["difference [% of length]"].tolist()


def test_equal_steps_have_one_curve_at_every_rate():
    same, other = differences(EQUAL)
    assert same == 0.0 and other < 1e-6


def test_steps_that_differ_are_seen():
    same, other = differences(LARGEST)
    assert same == 0.0 and other > 1e-3


def test_a_run_in_shorter_steps_is_another_one():
    assert min(differences(EQUAL, finer=4)) > 1e-4


@pytest.mark.parametrize(
    ("rates", "every", "message"),
    [
        ((24, 25), 0.5, "25 frames a second"),
        ((24,), 0.50001, "24 frames a second"),
        ((24,), 4e-4, "24 frames a second"),
        ((24,), 1e-9, "24 frames a second"),
        ((), 0.5, "no frame rates"),
    ],
)
def test_intervals_are_frames_of_every_rate(rates, every, message):
    with pytest.raises(BadInput, match=message):
        measure_rates(GROOM, None, rates=rates, every=every, intervals=1)
