"""`hairpipe validate`, of polygons against their circle, and the validations that are shipped."""

import json
import shutil
import sys

import pytest

import hairpipe as package
import hairpipe.graphs.experiments.validation.validation as validation
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.figures.file import read_results
from hairpipe.graphs.experiments.table.checks import checked
from hairpipe.values.table import table_of_rows

from ...app.cli.conftest import hairpipe  # noqa: F401
from ...sources import HOME
from ..figures.conftest import edit, git, repository  # noqa: F401

CHECKS = HOME / "graphs/experiments/nodes/check_errors.py"
VALIDATION = """schema = 1
frames = [1, 1]
fps = 24
[hexagon]
type = "measure_circle"
sides = [6]
[dodecagon]
like = "hexagon"
sides = [12]
[length]
type = "check_errors"
in.tables = ["hexagon", "dodecagon"]
cases = ["6 sides", "12 sides"]
row = "length of a polygon"
source = "circle & <closed> form"
column = "error [%]"
allowed = [5.0, 2.0]
[strict]
like = "length"
row = "the same, strictly"
allowed = [1.0, 2.0]
unpromised = ["6 sides"]
[rows]
type = "write_table"
in.tables = ["length", "strict"]
publish = "../out/rows.csv"
[quick]
type = "write_table"
in.tables = ["length"]
publish = "../out/quick.csv"
"""


@pytest.fixture
def polygons(repository):  # noqa: F811
    """The file of a validation whose promised rows are held, in a repository; the current folder."""
    path = repository / "graphs/polygons.toml"
    path.write_text(VALIDATION)
    shutil.copy(CHECKS, repository / "graphs/nodes")
    git(repository, "add", ".")
    git(repository, "commit", "-q", "-m", "a validation")
    yield path
    sys.modules.pop("check_errors", None)


def rows_of(text):
    """Read row, case, measured and verdict of a JSON document."""
    found = json.loads(text)["rows"]
    return [(row["row"], row["case"], round(row["measured"], 2), row["verdict"]) for row in found]


def test_promised_rows_that_are_held_end_with_success(polygons, hairpipe):  # noqa: F811
    done = hairpipe("validate graphs/polygons.toml -j1 -q --json")
    assert rows_of(done.stdout) == [
        ("length of a polygon", "6 sides", 4.51, "held"),
        ("length of a polygon", "12 sides", 1.14, "held"),
        ("the same, strictly", "6 sides", 4.51, "not promised"),
        ("the same, strictly", "12 sides", 1.14, "held"),
    ]
    assert done.exit_code == 0
    text = hairpipe("validate graphs/polygons.toml -j1 -q").stdout
    assert "2 rows, 4 cases: 3 held, 0 missed, 1 not promised" in text


def test_a_promised_row_that_is_missed_fails(polygons, hairpipe):  # noqa: F811
    edit(polygons, "allowed = [5.0, 2.0]", "allowed = [5.0, 1.0]")
    done = hairpipe("validate graphs/polygons.toml -j1 -q --json")
    assert [verdict for *_, verdict in rows_of(done.stdout)] == ["held", "missed", "not promised", "held"]
    assert done.exit_code == 1


def test_a_row_that_fails_is_not_held(polygons, hairpipe):  # noqa: F811
    edit(polygons, 'column = "error [%]"', 'column = "mistake [%]"')
    done = hairpipe("validate graphs/polygons.toml -j1 -q --json")
    assert rows_of(done.stdout) == [] and done.exit_code == 1
    edit(polygons, 'column = "mistake [%]"', 'column = "area"')  # which is not a number
    done = hairpipe("validate graphs/polygons.toml -j1 -q --json")
    assert [row["measured"] for row in json.loads(done.stdout)["rows"]] == [None] * 4 and done.exit_code == 1


def test_a_quick_run_computes_quick_rows_only(polygons, hairpipe):  # noqa: F811
    done = hairpipe("validate graphs/polygons.toml --quick -j1 -q --json")
    assert {row for row, *_ in rows_of(done.stdout)} == {"length of a polygon"} and done.exit_code == 0


def test_a_quick_run_without_quick_rows_is_refused(polygons, hairpipe):  # noqa: F811
    edit(polygons, "[quick]", "[others]")
    done = hairpipe("validate graphs/polygons.toml --quick -j1 -q")
    assert done.exit_code == 2 and "no node 'quick'" in done.stderr


def test_rows_are_recorded(polygons, hairpipe):  # noqa: F811
    assert hairpipe("validate graphs/polygons.toml -j1 -q --record").exit_code == 0
    found = read_results(polygons.parent / "results/polygons.json")
    assert [row[:2] for row in found.tables["rows"].rows][::2] == [
        ["length of a polygon", "6 sides"],
        ["the same, strictly", "6 sides"],
    ]
    assert found.command == "hairpipe run graphs/polygons.toml --to rows --record polygons"


def test_the_page_has_rows_and_no_markup_of_a_text(polygons, hairpipe, tmp_path):  # noqa: F811
    done = hairpipe("validate graphs/polygons.toml -j1 -q -o page.html")
    text = (tmp_path / "page.html").read_text()
    assert done.stdout.endswith("page: page.html\n")
    assert text.count("<tbody>") == 2 and "circle &amp; &lt;closed&gt; form" in text and "4.5 %" in text


def test_another_graph_is_refused(polygons, hairpipe):  # noqa: F811
    done = hairpipe("validate graphs/circle.toml -q")
    assert done.exit_code == 2 and "no node 'rows'" in done.stderr
    edit(polygons, 'in.tables = ["length", "strict"]', 'in.tables = ["length", "hexagon"]')
    done = hairpipe("validate graphs/polygons.toml -j1 -q")
    assert done.exit_code == 2 and "(tables of `check_errors`" in done.stderr


def test_a_wheel_has_no_validations(monkeypatch):
    monkeypatch.setattr(validation, "shipped_graphs", dict)
    with pytest.raises(BadInput, match="an installed wheel has no validations"):
        validation.shipped_validations()


def test_other_solvers_are_shown_as_recorded(hairpipe):  # noqa: F811
    text = hairpipe("validate --others").stdout
    for name in ("hairpipe 0.1.0", "PyElastica", "pyPBD", "Newton", "TR-BDF2", "recorded at commit", "bench swing"):
        assert name in text


CHECK = "check_errors"
MOST_QUICK_RESULTS = 5000
"""Of all validations: frames of single strands, mostly."""
FEWEST_ROWS, FEWEST_CASES = 25, 100
TABLE = table_of_rows(("case", "error [%]"), [("a", -3.0), ("a", 1.0), ("b", 2.0)])


@pytest.fixture(scope="module")
def validations(tmp_path_factory):
    """The shipped validations by name."""
    cache = tmp_path_factory.mktemp("validations") / "cache"
    return {name: package.load(name, cache=cache) for name in validation.shipped_validations()}


def checks_of(shot, node):
    """List the nodes of rows that a node collects."""
    return [shot.nodes[edge.node] for edge in shot.nodes[node].edges.values()]


def test_every_row_has_cases_with_bounds_and_a_source(validations):
    rows, cases = [], 0
    for shot in validations.values():
        for check in checks_of(shot, validation.ROWS):
            settings = check.settings
            assert check.type.name == CHECK
            assert len(check.edges) == len(settings["cases"]) == len(settings["allowed"])
            assert set(settings["unpromised"]) <= set(settings["cases"])
            assert settings["source"] and "[" in settings["column"]
            rows.append(settings["row"])
            cases += len(settings["cases"])
    assert len(set(rows)) == len(rows) >= FEWEST_ROWS and cases >= FEWEST_CASES


def test_every_check_is_collected(validations):
    for shot in validations.values():
        known = {node.name for node in checks_of(shot, validation.ROWS)}
        assert known == {node.name for node in shot.nodes.values() if node.type.name == CHECK}


def test_a_short_run_is_a_part_of_all_rows_and_short(validations):
    results = 0
    for shot in validations.values():
        node = validation.collecting_node(shot, quick=True)
        if node is not None:
            assert {check.name for check in checks_of(shot, node)} <= {
                check.name for check in checks_of(shot, validation.ROWS)
            }
            results += len(shot.plan(to=node))
            assert validation.measured_rows(shot, node) == []
    assert 0 < results <= MOST_QUICK_RESULTS


def test_validations_have_names_of_their_own():
    names = [name.removeprefix(validation.PREFIX) for name in validation.shipped_validations()]
    assert len(set(names)) == len(names) and "statics" in names


def test_the_largest_magnitude_of_a_case_is_compared():
    found = checked((TABLE, TABLE), ("a", "b"), "error [%]", (2.0, 2.0), (), ("row", "source"))
    assert [row[1:] for row in found.rows()] == [
        ("a", 3.0, 2.0, "%", "missed", "source"),
        ("b", 2.0, 2.0, "%", "held", "source"),
    ]


@pytest.mark.parametrize(
    ("cases", "unpromised", "message"),
    [
        (("a",), (), "2 tables, 1 cases"),
        (("a", "c"), (), "no rows of the case 'c'"),
        (("a", "b"), ("c",), "no case 'c'"),
    ],
)
def test_cases_that_do_not_fit_are_refused(cases, unpromised, message):
    with pytest.raises(BadInput, match=message):
        checked((TABLE, TABLE), cases, "error [%]", (1.0, 1.0), unpromised, ("row", "source"))
