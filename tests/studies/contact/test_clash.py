"""A bar through a tuft: what counts as through, and that hair slides over the bar and is not flung."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.data.table import table_of_rows
from hairpipe.errors import BadInput
from hairpipe.sim.hair_model import build_hair
from hairpipe.sim.material import Material
from hairpipe.sim.settings import Collisions, Scene, StepControl, Stiction, StrainLimit
from hairpipe.studies.contact.bar import RADIUS, axis_at, depth, passed_through, roots_at, tuft
from hairpipe.studies.contact.clash import COLUMNS, clash_table, fixed_steps, meet
from hairpipe.studies.contact.worst import GRAVITY, LENGTH, Seen, Worst, signs

LIMITED = Scene(strain=StrainLimit(0.02))


def tabulate(truth, scene, bar, seconds):
    hair = build_hair(tuft(), Material())

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


def test_hair_that_wins_energy_at_rest_grows_and_hair_that_falls_does_not():
    """All of it rises by a share of its length, at rest or by the speed with which it would."""
    for share, sign in ((0.11, "growing"), (0.09, ""), (-1.0, "")):
        worst, still = Worst(np.zeros(1, bool)), np.zeros((4, 3))
        rise = share * LENGTH * np.array([0.0, 1.0, 0.0])
        worst.end_frame(0.25, Seen(still + 100.0, still, 0.0, None))
        worst.end_frame(0.5, Seen(still, still, 0.0, None))
        worst.end_frame(0.75, Seen(still + rise, still, 0.0, None))
        assert signs(worst, 4.0) == sign
    upwards = np.full((4, 3), np.sqrt(2.2 * GRAVITY * 0.1 * LENGTH / 3.0))
    worst.end_frame(1.0, Seen(still, upwards, 0.0, None))
    assert signs(worst, 4.0) == "growing"


def test_bar_and_roots_stand_still_after_a_period_where_they_began():
    (place, rate), (before, _) = axis_at(2.0, 0.7), axis_at(2.0, 0.0)
    assert place == pytest.approx(before) and rate == pytest.approx(np.zeros(3), abs=1e-12)
    groom = tuft()
    led, start = roots_at(groom, 2.0, 0.7), roots_at(groom, 2.0, 0.0)
    assert led.roots == pytest.approx(start.roots) and led.roots_rate == pytest.approx(0.0 * led.roots, abs=1e-12)


def test_hair_that_a_bar_meets_slides_over_it():
    """At 1 m/s in steps of 1/240 s the bar goes 4 mm a step; with friction hair was stretched by 12 %, and flung."""
    found = meet(build_hair(tuft(), Material()), replace(LIMITED, steps=StepControl(1 / 240)), True, 1.0, 0.25)
    fine = meet(build_hair(tuft(), Material()), replace(LIMITED, steps=StepControl(1 / 960)), True, 1.0, 0.25)
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
