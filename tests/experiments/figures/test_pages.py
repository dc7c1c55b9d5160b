"""Pages are written from results."""

import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.figures.pages import names_of, without_states, written, written_page

from .conftest import edit


def is_as_written(page):
    text = page.read_text()
    return without_states(written_page(page, text, lambda path: "current")) == without_states(text)


def test_tables_and_spans_are_written(recorded, hairpipe):
    page = recorded / "graphs/README.md"
    assert not is_as_written(page)
    assert "graphs/README.md" in hairpipe("results --write").stdout
    text = page.read_text()
    assert "| 6 | -4.5 % |\n| 12 | -1.1 % |\n\n<!-- end -->" in text
    assert "At most <!-- results: circle {table; error [%]; largest; .2f} % -->4.51 %<!-- end --> of a circle." in text
    assert "(current); machine " in text and "; command `hairpipe run graphs/circle.toml --record`\n\n| sides" in text
    assert is_as_written(page)
    assert hairpipe("results --write graphs").stdout == ""


def test_a_page_that_was_edited_manually_is_found(recorded, hairpipe):
    page = recorded / "graphs/README.md"
    hairpipe("results --write")
    edit(page, "| 6 | -4.5 % |", "| 6 | -4.4 % |")
    assert not is_as_written(page)


def test_the_word_on_a_page_follows_the_code(recorded, hairpipe):
    edit(recorded / "graphs/nodes/rounding.py", "6", "5")
    hairpipe("results --write")
    text = (recorded / "graphs/README.md").read_text()
    assert "(older code); machine" in text
    assert is_as_written(recorded / "graphs/README.md")


@pytest.mark.parametrize(
    ("template", "message"),
    [
        ("circle {tabel; sides}", "no table 'tabel'"),
        ("circle {table; side}", "no column 'side'"),
        ("circle {table; sides; sides=7}", "no row with sides=7"),
        ("circle {table; sides}", "2 rows fit"),
        ("circle {table; sides; sides=6; .2q}", "'.2q' does not apply"),
        ("circle {table; area; largest}", "not all numbers"),
        ("circle {table}", "no column"),
        ("square {table; sides}", "square.json"),
    ],
)
def test_a_reference_that_leads_nowhere_is_named_with_its_line(recorded, template, message):
    page = recorded / "graphs/README.md"
    with pytest.raises(BadInput, match=message) as raised:
        written_page(page, f"one\ntwo <!-- results: {template} --><!-- end -->", lambda path: "")
    assert str(raised.value).startswith(f"{page}:2: ")


def test_a_marker_that_does_not_end_is_named(recorded):
    page, text = recorded / "graphs/README.md", "<!-- results: circle {table; sides; largest} -->6"
    for given in (text, f"{text}\n{text}<!-- end -->"):
        with pytest.raises(BadInput, match="does not end"):
            written_page(page, given, lambda path: "")


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


def test_results_of_other_folders_are_named_with_their_path(recorded):
    text = "<!-- results:\n| {graphs/circle.table; sides; max; .0f} {state; graphs/circle} |\n--><!-- end -->"
    assert names_of(text) == ["graphs/circle"]
    made = written_page(recorded / "README.md", text, lambda path: path.name)
    assert "\n| 12 (circle.json) |\n" in made and "commit" not in made


def test_a_table_of_two_results_is_below_the_commands_of_both(recorded, hairpipe):
    assert hairpipe("run graphs/circle.toml --record again").exit_code == 0
    text = "<!-- results: circle\n| {table; sides; max; .0f} | {again.table; sides; max; .0f} |\n--><!-- end -->"
    made = written_page(recorded / "graphs/README.md", text, lambda path: path.name)
    assert "circle.toml --record`;\ncommit" in made and "--record again`\n\n| 12 | 12 |\n" in made


def test_values_that_are_not_empty_are_counted(recorded):
    text = "<!-- results: circle {table; sides; count} {table; area; count} --><!-- end -->"
    assert "-->2 0<!--" in written_page(recorded / "graphs/README.md", text, lambda path: "")
