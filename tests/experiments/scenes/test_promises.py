"""What became of promises, and what scenes need, on numbers that are made up."""

import json
from dataclasses import replace

import pytest

from hairpipe.app.api.shot import load
from hairpipe.app.tune.measured import Chaos, Measured, Tolerance, failed
from hairpipe.app.tune.sampling import STILL, RootMotion, Sample
from hairpipe.app.tune.tuning import Check, Choice, Scene, Tuned, Untunable
from hairpipe.engine.run.events import Outcome
from hairpipe.graphs.experiments.scenes import needs, promises
from hairpipe.graphs.experiments.scenes.drawing import DrawnScene
from hairpipe.graphs.experiments.scenes.pace import Pace
from hairpipe.values.simplification import Simplification

DRY = Simplification("stiction", 1, "no stiction", drops=("hair.stiction",))
CHAIN = Simplification("model", 1, "plain chain", (("hair.model", "chain"),))
FEWER = Simplification("segments", 1, "10 segments, not 20", (("groom.segments", 10),))
BELOW = "nothing is promised below the floor of 5.8 %"
PERCENT = Tolerance(2.0, "%")
SAMPLE = Sample(96, 4, 0, 1, 13, 24)


def never(*_, timed=True) -> Outcome:
    raise AssertionError("nothing is run")


def found(error: float, seconds: float = 2.0, refused: str = "") -> Measured:
    return Measured(error, 1.25 * error, seconds, error, error, error, refused=refused)


def check(chosen: Measured, full: Measured) -> Check:
    return Check(replace(SAMPLE, number=1), found(0.1), full, chosen)


MOTION = RootMotion(0.5, 3.0)
GOOD = check(found(1.0), found(0.2))
TUNED = Tuned(
    strands=300,
    sample=SAMPLE,
    tolerance=PERCENT,
    reference=found(0.1),
    steps="steps up to 1/960 s",
    full=found(0.2, 8.0),
    singles={DRY: found(1.0)},
    choice=Choice(frozenset([DRY]), found(1.5), ()),
    checks=(GOOD, GOOD),
    motion=MOTION,
)
NOTHING = replace(TUNED, choice=Choice(None, found(3.0), ()), checks=())
TEXT = 'schema = 1\nframes = [1, 30]\nfps = 24\n[head]\ntype = "make_bust"\n'
TABLES = {"schema": 1, "frames": [1, 30], "fps": 24, "head": {"type": "make_bust"}}
SCENE = DrawnScene("300 hairs of 20 cm", PERCENT, TABLES, ("nods", TABLES | {"frames": [1, 40]}))


def promise(
    number: int, tuned: Tuned | None = TUNED, other: Check | None = GOOD, elsewhere: Check | None = GOOD
) -> promises.Promise:
    return promises.Promise(number, SCENE, tuned, elsewhere, other, MOTION if other else STILL)


@pytest.mark.parametrize(
    ("chosen", "full", "verdict"),
    [
        (found(1.9), found(0.2), "kept"),
        (found(1.9), found(2.5), "kept"),
        (found(3.1), found(0.2), "broken"),
        (found(2.1), found(0.2), "inconclusive"),
        (failed("hair is lost"), found(0.2), "broken"),
        (found(1.0, refused="significantly different in contacts"), found(0.2), "broken"),
        (found(3.1), found(2.5), "inconclusive"),
        (found(3.1), found(0.2, refused="the floor of chaos is above the tolerance"), "inconclusive"),
    ],
)
def test_a_promise_is_broken_only_where_it_could_be_kept(chosen, full, verdict):
    assert promise(1, other=check(chosen, full)).verdicts == ("kept", verdict)
    assert promise(1, elsewhere=check(chosen, full)).verdicts == (verdict, "kept")


def test_nothing_is_promised_of_a_harder_motion():
    """It is neither kept nor broken there, and what counts is what became of the promise elsewhere."""
    bad = check(found(3.1), found(0.2))
    harder = replace(promise(1, other=bad), motion=RootMotion(0.5, 3.2))
    assert harder.verdicts == ("kept", "outside") and promises.worst(harder) == "kept"
    assert promises.worst(replace(harder, elsewhere=bad)) == "broken"
    said = "kept: the other motion, up to 0.5 m/s and 3.2 m/s^2, is outside of 0.5 m/s and 3 m/s^2"
    assert promises.rows([harder])[1][-1] == said
    assert promises.summary([harder])[2].endswith(": 1 outside")


def test_a_failed_check_promises_nothing():
    fails = replace(
        TUNED, checks=(GOOD, check(found(3.1, refused="the floor of chaos is above the tolerance"), found(3.0)))
    )
    refused = promise(1, fails, None, None)
    assert promises.worst(refused) == "refused"
    assert promises.rows([refused])[1][3] == "nothing is promised: in a check the floor of chaos is above the tolerance"


def test_promises_are_counted_and_scenes_of_which_nothing_is_promised_apart():
    bad = check(found(3.1, refused="spreads twice as far"), found(0.2))
    tried = [promise(1), promise(2, other=bad), promise(3, NOTHING, None, None), promise(4, None, None, None)]
    first, strands, motion, *rest = promises.summary(tried)
    assert first == "1 of 2 promises kept, of 4 scenes"
    assert strands.endswith(": 2 kept") and motion.endswith(": 1 kept, 1 broken")
    assert [line.partition(",")[0] for line in rest] == ["kept: 1", "broken: 1", "refused: 1", "fails: 1"]


def test_every_row_has_what_was_promised_and_what_came_of_it():
    bad = check(found(3.1, refused="spreads twice as far"), found(0.2))
    rows = promises.rows(
        [promise(1), promise(2, other=bad), promise(3, NOTHING, None, None), promise(4, None, None, None)]
    )
    assert {len(row) for row in rows} == {len(promises.ALIGN)}
    assert rows[2] == (
        *("2", "300 hairs of 20 cm; then nods", "2 %", "no stiction"),
        *("1.5 (1.9)", "1 (1.2)", "3.1 (3.9)", "4.0", "broken: spreads twice as far"),
    )
    assert rows[3][3] == "nothing is promised: the graph as it is, with a larger error" and rows[3][-1] == "refused"
    assert rows[4][-1] == "fails"
    documents = json.loads(json.dumps(promises.document([promise(1), promise(4, None, None, None)])))
    assert documents[0]["promised"]["error"] == 1.5 and documents[1]["promised"] is None


def test_a_choice_is_measured_elsewhere_and_in_the_other_motion(monkeypatch, tmp_path):
    asked = []

    class Checking:
        def __init__(self, request, sample, scene, echo):
            self.place = request.shot.frames, sample.number

        def check(self, parts):
            asked.append((*self.place, parts))
            return GOOD

    monkeypatch.setattr(promises, "tune", lambda request, echo: TUNED)
    monkeypatch.setattr(promises, "look_at", lambda request: Scene(300, None, None, MOTION))
    monkeypatch.setattr(promises, "sample_of", lambda request, scene: SAMPLE)
    monkeypatch.setattr(promises, "Checking", Checking)
    shot = load(TEXT, cache=tmp_path / "cache")
    assert promises.try_promise(shot, 1, SCENE, never, print) == promise(1)
    assert asked == [(range(1, 31), 2, frozenset([DRY])), (range(1, 41), 2, frozenset([DRY]))]

    monkeypatch.setattr(promises, "tune", lambda request, echo: NOTHING)
    assert promises.try_promise(shot, 3, SCENE, never, print) == promise(3, NOTHING, None, None)

    def stuck(request, echo):
        raise Untunable("the unchanged graph fails on the sample")

    monkeypatch.setattr(promises, "tune", stuck)
    assert promises.try_promise(shot, 4, SCENE, never, print) == promise(4, None, None, None)
    assert len(asked) == 2


def test_needs_of_scenes_have_a_row_for_every_tolerance(monkeypatch, tmp_path):
    floor = Chaos(4e-4, 11, 0.46, 12, True, 13.0, 5.8)
    kept_at_first = {DRY: found(0.3), CHAIN: found(0.4, 1.5), FEWER: found(9.0, 0.5)}
    answers = [TUNED, replace(NOTHING, reference=floor, singles=kept_at_first)]
    monkeypatch.setattr(needs, "tune", lambda request, echo: answers.pop(0))
    reported = []
    pace = Pace(2, lambda: never, reported.append)
    shots = {"short": load(TEXT, cache=tmp_path / "cache")}
    rows = needs.rows(list(needs.needs_of(shots, "hair", [PERCENT, Tolerance(1e-3, "m")], pace, print)))
    assert rows[1] == ("short", "2 %", "no stiction", "1.5 (1.9)", "0.2 (0.25)", "4.0")
    assert rows[2][:3] == ("the same", "1 mm", f"{BELOW}; the first 0.46 s could do with plain chain")
    assert reported == ["1 of 2: short within 2 %", "2 of 2: short within 1 mm"]


def test_time_that_is_left_is_that_of_scenes_for_which_something_was_computed(tmp_path):
    time, reported = iter([0.0, 10.0, 70.0, 70.0, 72.0]), []
    outcomes = [Outcome(count, 0, 0, (), (), {}, {}, False) for count in (0, 5)]
    pace = Pace(4, lambda: lambda *_, timed: outcomes.pop(0), reported.append, lambda: next(time))
    shot = load(TEXT, cache=tmp_path / "cache")
    with pace.scene("known"):
        pace.run("", shot, [], [])
    with pace.scene("new"):
        pace.run("", shot, [], [])
    with pace.scene("nothing run"):
        pass
    with pace.scene("last"):
        pass
    assert reported[1] == "2 of 4: new"
    assert reported[2] == "3 of 4: nothing run; 1:00 min each, 2:00 min left" and reported[3].endswith("1:00 min left")
