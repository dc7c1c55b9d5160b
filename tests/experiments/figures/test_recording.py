"""What is recorded of graphs and benches, and which records are current."""

import json
import os
import sys
from dataclasses import replace

import pytest

import hairpipe as package
from hairpipe.engine.worker.machine_code import TABLE
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench import paper
from hairpipe.graphs.experiments.bench.machine import Machine
from hairpipe.graphs.experiments.bench.report import Report
from hairpipe.graphs.experiments.figures import recipe as state
from hairpipe.graphs.experiments.figures.bench_recording import BenchRecording
from hairpipe.graphs.experiments.figures.file import COST, read_results
from hairpipe.graphs.experiments.figures.recipe import CURRENT, OLDER, UNKNOWN, recipe_now, state_of
from hairpipe.processor import processor_class

from .conftest import edit, git


def test_recorded_values_are_those_of_the_run(recorded):
    results = read_results(recorded / "graphs/results/circle.json")
    measured = package.load("graphs/circle.toml").get("circle")
    table = results.tables["table"]
    assert table.columns == list(measured.names) == ["sides", "error [%]", "area"]
    assert [row[:2] for row in table.rows] == [list(row[:2]) for row in measured.rows()]
    assert [row[2] for row in table.rows] == [None, None]


def test_results_name_commit_machine_command_and_keys(recorded):
    results = read_results(recorded / "graphs/results/circle.json")
    assert results.commit == git(recorded, "rev-parse", "HEAD")
    assert results.machine.kind == processor_class() and results.machine.cores > 0
    assert results.command == "hairpipe run graphs/circle.toml --record"
    assert results.tables["table"].keys == {"circle": package.load("graphs/circle.toml").explain("circle").entry.key}
    assert results.processor >= 0.0 and results.nodes.keys() == {"circle", "table"}


def test_recorded_command_has_settings_frames_and_name(repository, hairpipe):
    done = hairpipe("run graphs/circle.toml -j1 -q --set circle.sides=[3] --frames 2 --to table --record coarse")
    assert done.exit_code == 0
    results = read_results(repository / "graphs/results/coarse.json")
    assert results.command.endswith(
        "run graphs/circle.toml --set 'circle.sides=[3]' --frames 2 --to table --record coarse"
    )
    assert results.settings == {"circle.sides": "[3]"} and results.frames == "2"


WEDGE = """
[wedge.fine]
axes.circle.sides = [[6, 12], [24]]
stop = []
"""


def test_tables_of_a_wedge_have_a_column_for_what_it_varies(repository, hairpipe):
    graph = repository / "graphs/circle.toml"
    graph.write_text(graph.read_text() + WEDGE)
    git(repository, "commit", "-qam", "a wedge")
    assert hairpipe("run graphs/circle.toml -j1 -q --wedge fine --record").exit_code == 0
    path = repository / "graphs/results/circle_fine.json"
    results = read_results(path)
    table = results.tables["table"]
    assert table.columns == ["circle.sides", "sides", "error [%]", "area"]
    assert [row[:2] for row in table.rows] == [["[6, 12]", 6], ["[6, 12]", 12], ["[24]", 24]]
    assert results.command.endswith("run graphs/circle.toml --wedge fine --record") and len(table.keys) == 2
    assert state_of(path).word == CURRENT
    edit(graph, "[24]", "[48]")
    assert state_of(path).word == OLDER


def test_uncommitted_code_is_not_recorded(repository, hairpipe, capsys):
    edit(repository / "graphs/nodes/rounding.py", "6", "7")
    done = hairpipe("run graphs/circle.toml -j1 -q --record")
    assert done.exit_code == 2 and "uncommitted changes: graphs/nodes/rounding.py" in done.stderr
    assert not (repository / "graphs/results").exists() and not (repository / "cache/actions").exists()


def test_pages_and_results_may_be_uncommitted(recorded, hairpipe):
    edit(recorded / "graphs/README.md", "At most", "Up to")
    assert hairpipe("run graphs/circle.toml -j1 -q --record").exit_code == 0


def test_cost_has_a_row_for_every_node(recorded):
    table = read_results(recorded / "graphs/results/circle.json").tables[COST]
    assert [row[:2] for row in table.rows] == [["circle", 1], ["table", 1]]
    assert all(value >= 0.0 for row in table.rows for value in row[2:])


def test_a_run_without_tables_records_its_cost(repository, hairpipe):
    (repository / "pages").mkdir()
    assert hairpipe("run graphs/circle.toml -j1 -q --to circle --record ../pages/cost").exit_code == 0
    path = repository / "pages/results/cost.json"
    results = read_results(path)
    assert results.tables.keys() == {COST} and results.nodes.keys() == {"circle"}
    assert [row[:2] for row in results.tables[COST].rows] == [["circle", 1]]
    assert results.graph == "../graphs/circle.toml" and state_of(path).word == CURRENT


def test_damaged_and_edited_files_are_named_in_one_line(recorded):
    path = recorded / "graphs/results/circle.json"
    text = path.read_text()
    for damaged, what in (
        (text[: len(text) // 2], "damaged"),
        ("[]", "damaged"),
        (text.replace("-4.507034", "-3.507034"), "changed by hand"),
        (text.replace('"format": 1', '"format": 2'), "format is 2"),
    ):
        path.write_text(damaged)
        with pytest.raises(BadInput, match=what) as raised:
            read_results(path)
        assert str(path) in str(raised.value) and "\n" not in str(raised.value)


MACHINE = Machine("A Processor", 2, {"numba": "1.2"})
CASES = [{"kernel": "solve", "median [ns]": 2.5, "floor": None}, {"kernel": "step", "ratio": 1.5}]


def test_the_table_of_the_paper_is_recorded(repository, hairpipe, monkeypatch):
    def measure(echo, scenes, store, overrides, moving, threads):
        return Report(paper.__name__, MACHINE, {"parts": [{"scene": "long_curly", "search [s]": 2.5}]})

    monkeypatch.setenv(TABLE, os.environ[TABLE])
    monkeypatch.setattr(paper, "measure_paper", measure)
    words = "bench paper long_curly --moving 7 --cache elsewhere --record graphs"
    monkeypatch.setattr(sys, "argv", ["hairpipe", *words.split()])
    assert hairpipe(words).exit_code == 0
    results = read_results(repository / "graphs/results/paper.json")
    assert results.command == "hairpipe bench paper long_curly --moving 7 --record graphs"
    assert results.tables["parts"].rows == [["long_curly", 2.5]]
    assert [name.rpartition("/")[2] for name in results.nodes] == ["long_curly.toml"]
    assert state_of(repository / "graphs/results/paper.json").word == CURRENT


def test_a_record_of_a_bench_has_the_name_that_is_given(repository, hairpipe, monkeypatch):
    monkeypatch.setenv(TABLE, os.environ[TABLE])
    monkeypatch.setattr(paper, "measure_paper", lambda *words: Report(paper.__name__, MACHINE, {"frames": CASES}))
    monkeypatch.setattr(sys, "argv", ["hairpipe", "bench", "paper"])
    assert hairpipe("bench paper long_curly --record graphs/short").exit_code == 0
    assert read_results(repository / "graphs/results/short.json").tables["frames"].rows[1][0] == "step"


def test_cases_become_rows_and_the_bandwidth_is_kept(repository):
    recording = BenchRecording(repository / "graphs", "toy")
    graph = repository / "graphs/circle.toml"
    recording.write(Report(paper.__name__, MACHINE, {"cases": CASES}, 16.04), "hairpipe bench toy", [graph])
    results = read_results(recording.path)
    assert results.tables["cases"].columns == ["kernel", "median [ns]", "floor", "ratio"]
    assert results.tables["cases"].rows == [["solve", 2.5, None, None], ["step", None, None, 1.5]]
    assert results.machine.bandwidth == 16.0 and results.commit == git(repository, "rev-parse", "HEAD")
    assert state_of(recording.path).word == CURRENT
    edit(graph, "12", "24")
    assert state_of(recording.path).changed == ("[circle.toml]",)


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
