"""Plans: what would run and why, said before it runs, and nothing written."""

import pytest

from hairpipe.engine import code
from hairpipe.engine.plan.planner import explain
from hairpipe.engine.plan.tasks import Task
from hairpipe.errors import BadInput
from hairpipe.processor import processor_class

pytestmark = pytest.mark.usefixtures("kept")


def snapshot(folder):
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*") if "__pycache__" not in path.parts}


def shown(plan, *names):
    """Status and reason of results."""
    return [f"{plan[name].status} {plan[name].reason}".strip() for name in names]


def test_plan_of_a_new_graph_writes_nothing(shot):
    before = snapshot(shot.folder)
    plan = shot.plan()
    assert shown(plan, "seed", "move@1", "sum@2") == ["run never evaluated", "depends seed", "depends move@2"]
    assert snapshot(shot.folder) == before


def test_plan_names_the_first_difference(shot):
    (shot.folder / "clip").write_bytes(b"abc")
    shot.change("value = 3", 'file = "clip"\nbent = {}')
    shot.run()
    before = snapshot(shot.folder)
    assert {entry.status for entry in shot.plan().values()} == {"cached"}
    plan = shot.plan(move__step=2)
    assert shown(plan, "seed", "move@3", "sum@1") == ["cached", "run setting step 1.0 -> 2.0", "depends move@1"]
    assert shown(shot.plan(seed__bent__strength=4), "seed") == ["run setting bent.strength 1.0 -> 4.0"]
    assert shown(shot.plan(list__parts="true"), "list") == ["run setting parts false -> true"]
    assert snapshot(shot.folder) == before
    (shot.folder / "clip").write_bytes(b"abd")
    assert shown(shot.plan(), "seed") == ["run contents of the file of setting file"]
    (shot.folder / "clip").write_bytes(b"abc")
    shot.edit("add_up.py", "0.9", "0.8")
    assert shown(shot.plan(), "sum@1", "sum@2", "list") == ["run code add_up", "depends sum@1", "depends sum@1"]
    shot.edit("tally.py", "FACTOR = 1.0", "FACTOR = 2.0")
    assert shown(shot.plan(), "seed") == ["run code tally"]


def test_a_plan_names_the_changed_input_as_an_explanation_does_and_runs_so(shot):
    shot.run()
    shot.run(move__turn=7, to=["move"])
    plan = shot.plan(move__turn=7)
    assert shown(plan, "move@7", "sum@7", "sum@8") == ["cached", "run input number", "depends sum@7"]
    assert plan["sum@6"].reason == "its full state, needed to continue, was not kept"
    assert [plan[f"sum@{frame}"].status for frame in (3, 4, 5)] == ["cached", "cached", "run"]
    for frame in (6, 7):
        found = explain(shot.load(move__turn=7), shot.store, Task("sum", frame))
        assert found.reasons == (plan[f"sum@{frame}"].reason,)
    ran = []
    shot.run(move__turn=7, report=lambda event: event.kind == "started" and ran.append(str(event.task)))
    assert sorted(ran) == sorted(name for name, entry in plan.items() if entry.status != "cached")


def test_new_frames_are_called_new(shot):
    shot.run()
    shot.change("[1, 10]", "[1, 11]")
    assert shown(shot.plan(), "move@10", "move@11", "list") == ["cached", "run new frame", "depends sum@11"]
    shot.run(to=["sum"])
    assert shown(shot.plan(), "list") == ["run input numbers frames 1-10 -> 1-11"]


def test_explain_gives_every_difference_and_the_key(shot):
    shot.run()
    found = explain(shot.load(move__step=2, move__turn=5), shot.store, Task("move", 4))
    assert found.reasons == ("setting step 1.0 -> 2.0", "setting turn 1000 -> 5")
    assert found.parts["time"] == {"frame": 4, "fps": 24.0}
    assert found.record is None
    assert explain(shot.load(), shot.store, Task("sum", 4)).record.outputs.keys() == {"number", "state"}
    for task in (Task("move", None), Task("seed", 3), Task("move", 11), Task("moev", 1)):
        with pytest.raises(BadInput):
            explain(shot.load(), shot.store, task)


def test_a_change_that_only_its_bits_show_has_a_reason_too(shot):
    shot.run(move__step=0.0)
    assert shot.plan(move__step=-0.0)["move@1"].reason == "setting step 0.0 -> -0.0"


def test_results_of_another_processor_class_are_not_used(shot, monkeypatch):
    shot.run()
    before = processor_class()
    monkeypatch.setattr(code, "processor_class", lambda: "z80")
    planned = shot.plan()["seed"]
    assert (planned.status, planned.reason) == ("run", f"class of processor {before} -> z80")
