"""A bar through a tuft: what counts as through, and that hair slides over the bar and is not flung."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.data.table import table_of_rows
from hairpipe.errors import BadInput
from hairpipe.sim.hair_model import build_hair
from hairpipe.sim.material import Material
from hairpipe.sim.settings import Collisions, Scene, StepControl, Stiction, StrainLimit
from hairpipe.studies.contact.bar import RADIUS, depth, passed_through, tuft
from hairpipe.studies.contact.clash import COLUMNS, Worst, clash_table, meet, signs

LIMITED = Scene(strain=StrainLimit(0.02))


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


def test_hair_that_a_bar_meets_slides_over_it():
    """At 1 m/s in steps of 1/240 s the bar goes 4 mm a step; with friction hair was stretched by 12 %, and flung."""
    found = meet(build_hair(tuft(), Material()), replace(LIMITED, steps=StepControl(1 / 240)), True, 1.0, 0.25)
    fine = meet(build_hair(tuft(), Material()), replace(LIMITED, steps=StepControl(1 / 960)), True, 1.0, 0.25)
    assert found.finite and found.stretch < 0.02 and found.deepest == 0.0 and not found.through.any()
    assert found.fastest == pytest.approx(fine.fastest, rel=0.15)


def test_with_everything_on_nothing_is_lost_in_whole_frames():
    scene = replace(LIMITED, stiction=Stiction(), collisions=Collisions())
    table = clash_table(None, scene, True, (8.0,), (24,), 0.25)
    assert table.names == COLUMNS and "NaN" not in table["failed"][0]


@pytest.mark.parametrize("stiction", [None, Stiction()])
def test_a_run_that_diverges_is_marked_also_where_hair_touches_hair(stiction):
    scene = Scene(gravity=1e300, stiction=stiction)
    assert clash_table(None, scene, False, (8.0,), (24,), 0.1)["failed"][0] == "NaN"


def test_a_converged_run_of_other_speeds_is_refused():
    truth = table_of_rows(COLUMNS, [("1 m/s", 0.1, 1, 0.0, 0, 0.0, 1.0, "")])
    with pytest.raises(BadInput, match="no 2 m/s"):
        clash_table(truth, LIMITED, True, (2.0,), (24,), 0.1)
