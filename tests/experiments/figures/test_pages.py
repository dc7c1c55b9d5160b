"""Figures of pages are those of the records."""

import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.figures import pages
from hairpipe.graphs.experiments.figures.pages import expanded, figure_of, is_equal, markdown_of, names_of, written


@pytest.fixture
def circle(recorded):
    """The folder of a graph that was recorded."""
    return recorded / "graphs"


def current(path):
    return "current"


TABLE = ["| sides | error |", "| --- | ---: |", "| {table; sides} | {table; error [%]; .2g} % |"]


def test_a_table_has_a_line_for_every_row_below_its_source(circle):
    made = markdown_of("circle", TABLE, "", current)
    assert made.endswith("| --- | ---: |\n| 6 | -4.5 % |\n| 12 | -1.1 % |")
    assert made.startswith("commit ") and "(current); machine " in made
    assert "; command `hairpipe run graphs/circle.toml --record`\n\n| sides" in made


def test_parts_of_all_references_stand_in_one_place(circle):
    made = markdown_of("circle", TABLE, "sides=12", current)
    assert made.endswith("| --- | ---: |\n| 12 | -1.1 % |")


def test_lines_add_their_own_to_the_references_of_the_columns():
    lines = [
        "| | {frames; frame [s]; .1f} | {parts; a; t=1} / {parts; a; t=2} |",
        "| one {scene=x} |",
        "| {a; b} | 2 | 3 |",
    ]
    first = "{frames; frame [s]; .1f; scene=x} | {parts; a; t=1; scene=x} / {parts; a; t=2; scene=x}"
    assert expanded(lines) == [f"| one  | {first} |", lines[2]]
    assert expanded(["| | {case=a} | {case=b} |", "| speed {table; v; .2g} |"]) == [
        "| speed  | {table; v; .2g; case=a} | {table; v; .2g; case=b} |"
    ]


@pytest.mark.parametrize(("text", "holds"), [("12", True), ("24/2", True), ("24/0", False), ("7", False), ("x", False)])
def test_numbers_are_compared_by_value(text, holds):
    assert is_equal(12.0, text) == holds


def test_the_word_of_a_table_follows_the_code(circle):
    assert "(older code); machine" in markdown_of("circle", TABLE, "", lambda path: "older code")


@pytest.mark.parametrize(
    ("name", "reference", "message"),
    [
        ("circle", "tabel; sides", "no table 'tabel'"),
        ("circle", "table; side", "no column 'side'"),
        ("circle", "table; sides; sides=7", "no row with sides=7"),
        ("circle", "table; sides", "2 rows fit"),
        ("circle", "table; sides; sides=6; .2q", "'.2q' does not apply"),
        ("circle", "table; area; largest", "not all numbers"),
        ("circle", "table", "no column"),
        ("square", "table; sides", "square.json"),
    ],
)
def test_a_reference_that_leads_nowhere_is_named(circle, name, reference, message):
    with pytest.raises(BadInput, match=message):
        figure_of(name, f"{{{reference}}}", current)


@pytest.mark.parametrize(
    ("value", "spec", "text"),
    [
        (12345.6, ".2g", "12,000"),
        (2.0, "#.2g", "2.0"),
        (42.3, "#.2g", "42"),
        (1e-8, ".1g", "1e-8"),
        (None, ".2g", "-"),
        ("6.", "", "6."),
    ],
)
def test_values_are_written_as_people_read_them(value, spec, text):
    assert written(value, spec) == text


def test_results_of_other_folders_are_named_with_their_path(circle, monkeypatch):
    monkeypatch.setattr(pages, "GRAPHS", circle.parent)
    text = "| {graphs/circle.table; sides; max; .0f} {state; graphs/circle} |"
    assert markdown_of("", [text], "", lambda path: path.name).endswith("\n| 12 (circle.json) |")
    assert names_of(f":::{{results}} other\n{text}\n:::\n{{results}}`third {{a; b}}`") == [
        "other",
        "graphs/circle",
        "third",
    ]


def test_a_table_of_two_results_is_below_the_commands_of_both(circle, hairpipe):
    assert hairpipe("run graphs/circle.toml --record again").exit_code == 0
    made = markdown_of("circle", ["| {table; sides; max; .0f} | {again.table; sides; max; .0f} |"], "", current)
    assert "circle.toml --record`;\ncommit" in made and made.endswith("--record again`\n\n| 12 | 12 |")


def test_values_that_are_not_empty_are_counted(circle):
    assert figure_of("circle", "{table; sides; count} {table; area; count}", current) == "2 0"
