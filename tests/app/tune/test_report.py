"""What is said of a scene that was tuned, on numbers that are made up."""

import json
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.app.tune import report
from hairpipe.app.tune.measured import (
    Chaos,
    Climate,
    Measured,
    Tolerance,
    bounded,
    failed,
    measured_of,
    seconds_per_frame,
)
from hairpipe.app.tune.sampling import RootMotion, Sample
from hairpipe.app.tune.tuning import Check, Choice, Guess, Trial, Tuned
from hairpipe.measure.deviation import PATCH_COLUMNS
from hairpipe.values.simplification import Simplification
from hairpipe.values.table import table_of_rows

DRY = Simplification("stiction", 1, "no stiction", drops=("hair.stiction",))
FEWER = Simplification("segments", 1, "10 segments, not 20", (("groom.segments", 10),))
CHAIN = Simplification("model", 1, "plain chain", (("hair.model", "chain"),))


def found(millimetres: float, seconds: float) -> Measured:
    error = 1e-3 * millimetres
    return Measured(error, 1.2 * error, seconds, error, millimetres / 2, error / 2)


FULL = found(0.1, 8.0)
BOTH = Trial(Guess(frozenset([DRY, FEWER]), 1.1e-3, 2.0), found(1.0, 2.5))
TUNED = Tuned(
    strands=5000,
    sample=Sample(96, 4, 0, 1001, 1013, 1024),
    tolerance=Tolerance(2e-3, "m"),
    reference=found(0.02, 30.0),
    steps="steps up to 1/960 s",
    full=FULL,
    singles={DRY: found(0.5, 4.0), FEWER: found(0.8, 5.0), CHAIN: failed("a chain is straight")},
    choice=Choice(BOTH.guess.parts, BOTH.measured, (BOTH,)),
)


def said(tuned: Tuned) -> str:
    """What is said of an outcome: header and conclusion."""
    return "\n".join(report.header(tuned) + report.conclusion(tuned))


def test_every_row_says_why():
    verdicts = {row[0]: row[-1] for row in report.rows(TUNED)}
    assert verdicts["no stiction"] == verdicts["10 segments, not 20"] == "left out"
    assert verdicts["plain chain"] == "kept: fails, see below"
    assert report.fault_lines(TUNED) == ["plain chain: a chain is straight"]
    far = replace(TUNED, singles={FEWER: found(1.9, 5.0)}, choice=Choice(frozenset(), FULL, ()))
    assert report.rows(far)[-1][-1] == "kept: may be beyond 2 mm", "the error is not, its bound is"
    (line,) = report.trial_lines(TUNED)
    assert "10 segments, not 20; no stiction" in line and line.endswith("taken")


def test_the_conclusion_gives_the_error_and_what_it_saves():
    text = said(TUNED)
    assert "error 1 mm (at most 1.2)" in text and "3.2 times as fast" in text and TUNED.kept


def test_unmet_tolerance_is_reported():
    nothing = replace(TUNED, tolerance=Tolerance(1e-5, "m"), choice=Choice(None, FULL, ()))
    text = said(nothing)
    assert not nothing.kept and "not converged within 0.01 mm" in text
    assert "nothing keeps 0.01 mm: not even the unchanged graph, with an error of 0.1 mm" in text


def test_budget_reports_its_smallest_error():
    tried = Trial(Guess(frozenset([DRY]), 7e-3, 1.0), found(7.0, 0.9))
    bought = replace(TUNED, budget=1.0, affordable=Choice(frozenset([DRY]), tried.measured, (tried,)))
    text = "1 s a frame buy an error of 7 mm (at most 8.4), for 0.9 s, with these left out: no stiction"
    assert text in said(bought)
    trials = [trial["left_out"] for trial in report.document(bought, None)["combinations"]]
    assert trials == [["10 segments, not 20", "no stiction"], ["no stiction"]]


def test_a_time_that_was_not_enough_is_reported():
    assert "stopped after 10:00 min of processor time" in said(replace(TUNED, stopped=600.0))
    assert "stopped" not in said(TUNED) and report.document(TUNED, None)["stopped"] is None


GOOD_CHECK = Check(Sample(96, 4, 1, 1040, 1052, 1063), found(0.02, 30.0), FULL, found(1.0, 2.4))


@pytest.mark.parametrize(("error", "kept"), [(1.9, True), (2.1, False)])
def test_a_check_can_break_the_promise(error, kept):
    check = Check(Sample(96, 4, 2, 1064, 1076, 1087), found(0.02, 30.0), FULL, found(error, 2.4))
    checked = replace(TUNED, checks=(GOOD_CHECK, check))
    assert checked.kept is kept
    assert report.conclusion(checked)[-1].endswith("the tolerance holds" if kept else "beyond 2 mm")


def test_check_reports_what_it_shares_with_the_sample():
    """Of few strands and frames there are no others; and a reference that fails takes nothing of the rest away."""
    check = Check(Sample(96, 4, 0, 1001, 1020, 1031), failed("it blew up"), FULL, found(1.0, 2.4))
    text = said(replace(TUNED, checks=(check,)))
    assert "as in the sample: all strands and 5 of the frames" in text and "twice as long ones: it blew up" in text
    assert "as in the sample" not in said(replace(TUNED, checks=(GOOD_CHECK,)))


def test_a_combination_that_fails_the_check_is_named():
    failed_check = replace(TUNED, choice=Choice(frozenset(), FULL, (BOTH,), (BOTH.guess.parts, frozenset([DRY]))))
    (line,) = report.trial_lines(failed_check)
    assert line.endswith("not taken, beyond it in a check")
    verdicts = {row[0]: row[-1] for row in report.rows(failed_check)}
    assert verdicts["no stiction"] == "kept: beyond 2 mm in a check"


def test_motions_of_other_graphs_are_within_the_promise_or_not():
    moving = replace(TUNED, motion=RootMotion(0.5, 3.0))
    assert report.conclusion(moving)[-1].endswith("no more than 0.5 m/s and 3 m/s^2 over half a second")
    assert report.conclusion(TUNED)[-1] == "holds where roots are at rest"
    others = {"nod.toml": RootMotion(0.4, 3.0), "run.toml": RootMotion(0.4, 9.0)}
    assert report.motion_lines(moving, others) == [
        "nod.toml: roots reach 0.4 m/s and 3 m/s^2: within these motions",
        "run.toml: roots reach 0.4 m/s and 9 m/s^2: outside of these motions",
    ]
    also = report.document(moving, None, others)["also"]
    assert also["nod.toml"]["within"] and not also["run.toml"]["within"]
    nothing = replace(moving, choice=Choice(None, FULL, ()))
    assert not report.motion_lines(nothing, others)


CHAOS = Chaos(4e-4, 11, 0.46, 1012, True, 13e-3, 1.5e-3)


def test_guarantee_of_chaotic_hair_has_its_duration():
    climate = Climate(1e-3, 1.4e-3, 1.1, 1.2, 0.04, {"contacts": 1.2})
    choice = replace(TUNED.choice, measured=replace(BOTH.measured, climate=climate))
    chaotic = replace(TUNED, reference=CHAOS, choice=choice)
    text = said(chaotic)
    assert "chaotic: 13 mm apart after frame 1012, floor 1.5 mm" in text
    assert (
        "keeps 2 mm with 90 % confidence up to frame 1012 (0.46 s); chaos: from then on two references are 13" in text
    )
    assert "the error of its mean is at most 1.4 mm" in text
    assert "differs significantly from the reference in contacts (1.2 times chance); --looks" in text
    document = json.loads(json.dumps(report.document(chaotic, None)))
    assert document["chosen"]["climate"]["significant"] == {"contacts": 1.2}
    alike = replace(choice, measured=replace(BOTH.measured, climate=replace(climate, p=0.3)))
    text = said(replace(chaotic, choice=alike))
    assert "does not differ significantly from the reference in position, density" in text and "--looks" not in text
    calm = replace(TUNED, reference=replace(CHAOS, chaotic=False, apart=1e-4, floor=0.0))
    assert "not chaotic: they are at most 0.1 mm apart" in said(calm) and "confidence" not in said(calm)


def test_below_the_floor_the_guaranteed_time_is_reported():
    below = replace(
        TUNED,
        reference=replace(CHAOS, floor=5.8e-3),
        choice=Choice(None, replace(found(6.0, 8.0), refused="the floor of chaos is above the tolerance"), ()),
        singles={DRY: replace(found(0.5, 4.0), screened=True)},
    )
    text = said(below)
    assert "chaos floor 5.8 mm (3 + 4 members): a tolerance of 2 mm can be promised up to frame 1012 only" in text
    assert "up to frame 1012 its tips are 0.1 mm off" in text
    assert not below.kept and "the floor of chaos is above the tolerance" in text
    assert report.rows(below)[-1][-1] == "kept: keeps it only as far as hair can be predicted"


def test_the_document_is_json():
    document = json.loads(json.dumps(report.document(TUNED, "fragment"), allow_nan=False))
    assert document["chosen"]["left_out"] == ["10 segments, not 20", "no stiction"]
    assert document["simplifications"][2]["error"] is None


def table(tips: list[list[float]], lost: int = 0, whole: float = 0.5):
    """A table of frames by patches; whole strands are so many times as far off as tips."""
    errors = ((f, p, tip) for f, t in enumerate(tips) for p, tip in enumerate(t))
    return table_of_rows(PATCH_COLUMNS, [(f, p, 10, e, whole * e, 10 * e, 10 * whole * e, lost) for f, p, e in errors])


def test_patches_that_agree_promise_what_they_show():
    assert bounded(table([[2.0, 2.0], [2.0, 2.0]]), "tip [m]") == pytest.approx((2.0, 2.0))


def test_the_more_patches_differ_the_less_is_promised():
    bounds = [bounded(table([[0.0, spread], [spread, 0.0]]), "tip [m]") for spread in (1.0, 2.0)]
    assert bounds[0] == pytest.approx((np.sqrt(0.5), np.sqrt(0.5)))
    apart = bounded(table([[0.0, 1.0], [0.0, 1.0]]), "tip [m]")
    student = 3.0777  # nine times in ten, one degree of freedom: any table of the distribution
    assert apart == pytest.approx((np.sqrt(0.5), np.sqrt(0.5 + student * 0.5)), rel=1e-4)


def test_lost_strands_are_a_fault_of_the_model():
    assert measured_of(table([[1.0, 1.0]], lost=1), Tolerance(1.0, "%"), 1.0, []).fault
    assert measured_of(table([[1.0, 1.0]]), Tolerance(1.0, "%"), 1.0, [0]).error == pytest.approx(10.0)


def test_whole_strands_count_where_they_are_farther_off_than_tips():
    assert measured_of(table([[1.0, 1.0]], whole=2.0), Tolerance(1.0, "%"), 1.0, [0]).error == pytest.approx(20.0)


def test_hair_is_scaled_to_the_scene_and_bodies_are_not():
    assert seconds_per_frame([[0.1, 0.2, 9.0], [0.01]], [[0.5, 0.5]], 4, 10.0) == pytest.approx(2.0 + 0.1 + 0.25)
