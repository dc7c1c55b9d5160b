"""`hairpipe plan`: what would be done and why, and that it leaves no trace."""

import json

from hairpipe.app.api.reports import plan_rows
from hairpipe.engine.plan.planner import Entry
from hairpipe.engine.plan.tasks import Task


def plan(hairpipe, arguments: str = "") -> dict[str, str]:
    """Lines of a plan by node; those of one node joined."""
    lines: dict[str, str] = {}
    name = ""
    for line in hairpipe(f"plan shot.toml {arguments}").stdout.splitlines()[:-1]:
        name = line.split()[0] if not line.startswith(" ") else name
        lines[name] = " ".join([lines.get(name, ""), *line.removeprefix(name).split()]).strip()
    return lines


AFTER_MOVE = {"sum": "1-6 depends on move", "list": "depends on sum", "drawing": "1-6 depends on sum"}


def test_before_the_first_run_all_is_planned_and_nothing_is_written(shot, hairpipe):
    found = {"seed": "will run: never evaluated", "move": "1-6 depends on seed"} | AFTER_MOVE
    assert plan(hairpipe) == found and not (shot.parent / "cache").exists()


def test_after_a_run_all_is_cached(computed, hairpipe):
    assert hairpipe("plan shot.toml").stdout.endswith("0 results to compute, 20 cached\n")


def test_a_setting_is_named_with_both_values(computed, hairpipe):
    found = {"seed": "cached", "move": "1-6 will run: setting turn 1000 -> 4"} | AFTER_MOVE
    assert plan(hairpipe, "--set move.turn=4") == found


def test_an_input_is_named(computed, hairpipe):
    hairpipe("run shot.toml -j1 -q --set move.turn=4 --to move")
    assert plan(hairpipe, "--set move.turn=4")["sum"] == "1-3 cached 4 will run: input number 5-6 depends on sum"


def test_a_document(computed, hairpipe):
    document = json.loads(hairpipe("plan shot.toml --json --to seed --set seed.value=4").stdout)
    assert document["tasks"] == [{"node": "seed", "frame": None, "status": "run", "reason": "setting value 3.0 -> 4.0"}]


def test_frames_that_wait_for_the_same_node_are_folded():
    entries = [Entry(Task("hair", 1), "cached")]
    entries += [Entry(Task("hair", frame), "depends", f"body@{frame}") for frame in (2, 3, 4)]
    assert plan_rows(entries) == [("hair", "1", "cached"), ("", "2-4", "depends on body")]


def test_bad_input_is_exit_code_2(shot, hairpipe):
    shot.write_text(shot.read_text().replace('in.seed = "seed"', 'in.seed = "sed"'))
    result = hairpipe("plan shot.toml")
    assert result.exit_code == 2
    assert result.stderr == "hairpipe: shot.toml:9: [move] move_seed: in.seed: no node 'sed' (did you mean 'seed'?)\n"
