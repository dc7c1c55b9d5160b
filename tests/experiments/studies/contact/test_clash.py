"""A bar through a tuft: what counts as through, and that hair slides over the bar and is not flung."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.contact.bar import RADIUS, axis_at, depth, passed_through, roots_at, tuft
from hairpipe.graphs.experiments.studies.contact.clash import COLUMNS, clash_table, fixed_steps, meet
from hairpipe.graphs.experiments.studies.contact.worst import GRAVITY, GROWN, Seen, Worst, signs
from hairpipe.laws.settings import Collisions, Locks, StepControl, Stiction, StrainLimit
from hairpipe.shot.settings import Scene
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
from hairpipe.values.table import table_of_rows

LIMITED = Scene(strain=StrainLimit(0.02))


def tabulate(truth, scene, bar, seconds):
    hair = build_hair(tuft(), Material(), "network")

    def run(speed, rate):
        return meet(hair, replace(scene, steps=fixed_steps(rate)), bar, speed, seconds)

    return clash_table(truth, run, (8.0,), (24,))


def test_through_is_across_the_axis_and_not_around_it():
    """Three hanging strands: one goes through from left to right, one passes above the axis, one winds around it."""
    hanging = np.stack([np.full(5, -0.02), np.linspace(0.05, -0.05, 5), np.zeros(5)], axis=1)
    aside = np.array([0.04, 0.0, 0.0])
    above = hanging + np.array([0.0, 0.08, 0.0])
    angles = np.linspace(0.5, 5.0, 5)
    wound = 0.02 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    before = np.concatenate([hanging, above, wound])
    after = np.concatenate([hanging + aside, above + aside, wound @ turn.T])
    offsets = np.array([0, 5, 10, 15])
    assert passed_through(before, after, offsets).tolist() == [True, False, False]
    assert depth(wound) == 0.0 and depth(0.5 * wound) == pytest.approx(RADIUS - 0.01)


def test_signs():
    worst = Worst(np.zeros(1, bool), stretch=0.11, fastest=3.0)
    assert signs(worst, 4.0) == "stretch" and signs(worst, 2.0) == "stretch, flung"
    worst.through[0] = True
    assert signs(worst, 2.0) == "through, stretch, flung"
    worst.finite = False
    assert signs(worst, 4.0) == "NaN"


def test_energy_won_after_the_bar_rests_grows_and_energy_lost_does_not():
    """More than it takes to lift all of it by the radius of the bar, from any frame to a later one."""
    still = np.zeros((4, 3))
    for radii, sign in ((1.1, "growing"), (0.9, ""), (-1.0, "")):
        worst, seen = Worst(np.zeros(1, bool)), Seen(still, still, 0.0, None)
        for seconds, energy in ((0.25, -9.0), (0.5, 2.0), (0.75, 1.0), (1.0, 1.0 + radii * GRAVITY * RADIUS)):
            worst.end_frame(seconds, seen, energy)
        assert signs(worst, 4.0) == sign


@pytest.mark.parametrize(("locks", "won"), [(None, 1e-3), (Locks(after=1), 0.1 * GROWN)])
def test_hair_that_swings_out_wins_no_energy_and_next_to_none_where_it_is_carried(locks, won):
    scene = replace(LIMITED, steps=fixed_steps(240), stiction=Stiction(2.4e-3, 6e-3), locks=locks)
    worst = meet(build_hair(tuft(), Material(), "network"), scene, False, 0.5, 0.75)
    assert len(worst.energies) == 7 and worst.grown < won
    assert (worst.simulated < 32) == (locks is not None)


def test_bar_and_roots_are_at_rest_after_a_period_where_they_began():
    (place, rate), (before, _) = axis_at(2.0, 0.7), axis_at(2.0, 0.0)
    assert place == pytest.approx(before) and rate == pytest.approx(np.zeros(3), abs=1e-12)
    groom = tuft()
    led, start = roots_at(groom, 2.0, 0.7), roots_at(groom, 2.0, 0.0)
    assert led.roots == pytest.approx(start.roots) and led.roots_rate == pytest.approx(0.0 * led.roots, abs=1e-12)


def test_hair_that_a_bar_meets_slides_over_it():
    """At 1 m/s in steps of 1/240 s the bar goes 4 mm a step; with friction hair was stretched by 12 %, and flung."""
    hair, steps = build_hair(tuft(), Material(), "network"), (StepControl(1 / 240), StepControl(1 / 960))
    found, fine = (meet(hair, replace(LIMITED, steps=each), True, 1.0, 0.25) for each in steps)
    assert found.finite and found.stretch < 0.02 and found.deepest == 0.0 and not found.through.any()
    assert found.fastest == pytest.approx(fine.fastest, rel=0.15)


def test_with_everything_on_nothing_is_lost_in_whole_frames():
    scene = replace(LIMITED, stiction=Stiction(), collisions=Collisions())
    table = tabulate(None, scene, True, 0.25)
    assert table.names == COLUMNS and "NaN" not in table["failed"][0]


@pytest.mark.parametrize("stiction", [None, Stiction()])
def test_a_run_that_diverges_is_marked_also_where_hair_touches_hair(stiction):
    scene = Scene(gravity=1e300, stiction=stiction)
    assert tabulate(None, scene, False, 0.1)["failed"][0] == "NaN"


def test_a_converged_run_of_other_speeds_is_refused():
    truth = table_of_rows(COLUMNS, [("1 m/s", 0.1, 1, 0.0, 0.0, 0, 0.0, 1.0, 0.0, 32, "")])
    with pytest.raises(BadInput, match="no 8 m/s"):
        tabulate(truth, LIMITED, True, 0.1)
