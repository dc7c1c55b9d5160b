"""Scans that diverge: who takes what was reached goes on with it, everybody else is told."""

from collections import deque

import pytest

from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.run.events import Judge
from hairpipe.engine.run.survey import NodeSurvey, Survey

BLOW_UP = '''"""A fold that diverges."""
from numeral import Numeral
from tally import numeral, tally
from hairpipe.engine import Time, node

@node(frames="scan")
def blow_up(number: Numeral, previous: Numeral | None, time: Time, *, at: int = 4, how: str = "diverge") -> Numeral:
    """Grow.

    at   frame
    how  it ends
    """
    tally("blow_up", time.frame)
    if time.frame == at:
        raise {"diverge": ArithmeticError, "zero": ZeroDivisionError}[how]("too much")
    return numeral(number.value + (previous.value if previous else 0.0))
'''
COUNT = '''"""A count of what was reached."""
from numeral import Numeral
from tally import numeral, tally
from hairpipe.engine import Reached, node

@node(frames="once")
def count(numbers: tuple[Reached[Numeral], ...]) -> Numeral:
    """Count frames, and add up what is in the last."""
    tally("count")
    return numeral(sum(1000 * len(shot) + shot[max(shot)].value for shot in numbers))
'''
GRAPH = """schema = 1
frames = [1, 6]
fps = 24
[seed]
type = "make_seed"
[move]
type = "move_seed"
in.seed = "seed"
step = 0
[wild]
type = "blow_up"
in.number = "move"
[calm]
like = "wild"
at = 0
[count]
type = "count"
in.numbers = ["calm", "wild"]
[after]
type = "gather"
in.numbers = ["count"]
"""


@pytest.fixture
def diverging(shot):
    """A shot in which one of two scans diverges at frame 4."""
    (shot.nodes / "blow_up.py").write_text(BLOW_UP)
    (shot.nodes / "count.py").write_text(COUNT)
    shot.write(GRAPH)
    return shot


def test_reached_frames_are_used_with_a_warning_and_the_failed_one_is_tried_again(diverging):
    outcome = diverging.run()
    assert outcome.exit_code == 0 and not outcome.failures and outcome.blocked == 0
    assert diverging.warned == [("wild@4", "ArithmeticError: too much; frames before are used")]
    assert diverging.tally()["blow_up"] == 6 + 4
    plan = diverging.plan()
    assert plan["wild@4"].status == "run" and "diverged" in plan["wild@4"].reason
    assert plan["count"].status == plan["after"].status == "cached"
    assert diverging.value("count") == 6000 + 6 + 3000 + 3
    assert diverging.run().exit_code == 0 and diverging.tally() == {"blow_up": 1}


def test_a_survey_is_complete_without_the_frames_after_a_divergence(diverging):
    survey = Survey(diverging.load(), diverging.store, None, Judge())
    assert not survey.complete
    diverging.run()
    survey.update()
    diverged = [str(task) for task, state in survey.states.items() if state == "diverged"]
    assert survey.complete and diverged == ["wild@4", "wild@5", "wild@6"]
    wild = survey.nodes["wild"]
    assert (wild.done, wild.total, wild.diverged, wild.waiting) == (3, 3, 3, 0)


@pytest.mark.parametrize(("rate", "left"), [(3.0, (60.0 + 24.0) / 3), (6.0, 48.0)])
def test_frames_are_divided_among_machines_but_not_those_of_a_simulation(shot, monkeypatch, rate, left):
    nodes = {
        "seed": NodeSurvey(1, 1, evaluated=1),
        "move": NodeSurvey(10, 1, evaluated=4, running={Task("move", 5)}, recent=deque([10.0])),
        "sum": NodeSurvey(10, 1, evaluated=2, running={Task("sum", 3)}, recent=deque([rate])),
        "list": NodeSurvey(1, 1, evaluated=1),
    }
    survey = Survey(shot.load(), shot.store, None, Judge())
    monkeypatch.setattr(Survey, "nodes", nodes)
    assert survey.seconds_left is None, "nothing is computed"
    survey.hosts = dict.fromkeys([Task("move", 5), Task("sum", 3), Task("sum", 4)], "here")
    assert survey.seconds_left == left
    nodes["list"].evaluated = 0
    assert survey.seconds_left is None, "the list has no rate"


def test_the_result_is_that_of_as_many_frames(diverging):
    diverging.write(GRAPH + '[list]\ntype = "write_list"\nin.numbers = "shown"\npublish = "list.txt"\n'
                    + '[shown]\ntype = "soften"\nin = { number = "move", other = "count" }\n')  # fmt: skip
    assert diverging.run().exit_code == 0
    first = (diverging.folder / "list.txt").read_text().splitlines()[0]
    assert float(first.split()[1]) == 1.0 + (6000 + 6) + (3000 + 3)


@pytest.mark.parametrize("settings", [{"wild__how": "zero"}, {"wild__at": 1}], ids=["a fault", "nothing reached"])
def test_other_failures_stop_the_run(diverging, settings):
    outcome = diverging.run(**settings)
    assert outcome.exit_code == 1 and outcome.failures[0].task.node == "wild"


def test_divergence_fails_nodes_that_need_all_frames(diverging):
    diverging.write(GRAPH + '[list]\ntype = "write_list"\nin.numbers = "wild"\n')
    outcome = diverging.run()
    assert [(failure.kind, str(failure.task)) for failure in outcome.failures] == [("diverged", "wild@4")]
    assert outcome.exit_code == 1
