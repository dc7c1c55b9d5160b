"""What `hairpipe run --record` writes, and when it refuses."""

import pytest

import hairpipe as package
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.figures.file import COST, read_results
from hairpipe.graphs.experiments.figures.recipe import CURRENT, OLDER, state_of
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
