"""Which results are current, and what has changed since the others."""

import json
from dataclasses import replace

from hairpipe.graphs.experiments.figures import recipe as state
from hairpipe.graphs.experiments.figures.file import read_results
from hairpipe.graphs.experiments.figures.recipe import CURRENT, OLDER, UNKNOWN, recipe_now, state_of

from .conftest import edit

RESULTS = "graphs/results/circle.json"


def test_results_of_the_same_code_are_current(recorded, hairpipe):
    edit(recorded / "graphs/nodes/rounding.py", "Round a number.", "Round a number to six digits.")
    done = hairpipe("results graphs/README.md")
    assert done.exit_code == 0 and "1 results file, 1 current" in done.stdout


def test_changed_code_is_named_by_its_file(recorded, hairpipe):
    edit(recorded / "graphs/nodes/rounding.py", "6", "5")
    found = state_of(recorded / RESULTS)
    assert found.word == OLDER and found.changed == ("graphs/nodes/rounding.py",)
    done = hairpipe("results graphs/README.md")
    assert done.exit_code == 1
    assert "graphs/nodes/rounding.py" in done.stdout and "hairpipe run graphs/circle.toml --record" in done.stdout


def test_changed_settings_are_named_by_their_node(recorded):
    edit(recorded / "graphs/circle.toml", "[6, 12]", "[6, 24]")
    assert state_of(recorded / RESULTS).changed == ("[circle]",)


def test_code_that_is_no_longer_used_is_named(recorded):
    edit(recorded / "graphs/nodes/measure_circle.py", "import rounding\n", "")
    changed = state_of(recorded / RESULTS).changed
    assert any("rounding" in name and "no longer used" in name for name in changed)


def test_a_graph_that_cannot_be_loaded_is_not_compared(recorded):
    (recorded / "graphs/circle.toml").unlink()
    found = state_of(recorded / RESULTS)
    assert found.word == UNKNOWN and "circle.toml" in found.changed[0]


def test_code_is_not_compared_with_that_of_another_python(recorded, monkeypatch):
    now = recipe_now(recorded / RESULTS, read_results(recorded / RESULTS))
    monkeypatch.setattr(state, "recipe_now", lambda path, results: replace(now, modules={}, python="2.7"))
    found = state_of(recorded / RESULTS)
    assert found.word == UNKNOWN and found.changed[0].endswith("-> 2.7")


def test_results_are_found_by_page_graph_file_and_folder(recorded, hairpipe):
    for given in ("", "graphs", "graphs/README.md", "graphs/circle.toml", RESULTS):
        listed = json.loads(hairpipe(f"results {given} --json").stdout)["results"]
        assert [(entry["path"].removeprefix("./"), entry["state"]) for entry in listed] == [(RESULTS, CURRENT)]
    assert "no results belong to it" in hairpipe("results graphs/nodes/rounding.py").stderr
