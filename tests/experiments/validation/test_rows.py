"""The validations that are shipped: every row is well formed, and a short run stays short."""

import pytest

import hairpipe
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.table.checks import checked
from hairpipe.graphs.experiments.validation.validation import (
    PREFIX,
    ROWS,
    collecting_node,
    measured_rows,
    shipped_validations,
)
from hairpipe.values.table import table_of_rows

CHECK = "check_errors"
MOST_QUICK_RESULTS = 5000
"""Of all validations: frames of single strands, mostly."""
FEWEST_ROWS, FEWEST_CASES = 25, 100
TABLE = table_of_rows(("case", "error [%]"), [("a", -3.0), ("a", 1.0), ("b", 2.0)])


@pytest.fixture(scope="module")
def validations(tmp_path_factory):
    """The shipped validations by name."""
    cache = tmp_path_factory.mktemp("validations") / "cache"
    return {name: hairpipe.load(name, cache=cache) for name in shipped_validations()}


def checks_of(shot, node):
    """List the nodes of rows that a node collects."""
    return [shot.nodes[edge.node] for edge in shot.nodes[node].edges.values()]


def test_every_row_has_cases_with_bounds_and_a_source(validations):
    rows, cases = [], 0
    for shot in validations.values():
        for check in checks_of(shot, ROWS):
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
        known = {node.name for node in checks_of(shot, ROWS)}
        assert known == {node.name for node in shot.nodes.values() if node.type.name == CHECK}


def test_a_short_run_is_a_part_of_all_rows_and_short(validations):
    results = 0
    for shot in validations.values():
        node = collecting_node(shot, quick=True)
        if node is not None:
            assert {check.name for check in checks_of(shot, node)} <= {check.name for check in checks_of(shot, ROWS)}
            results += len(shot.plan(to=node))
            assert measured_rows(shot, node) == []
    assert 0 < results <= MOST_QUICK_RESULTS


def test_validations_have_names_of_their_own():
    names = [name.removeprefix(PREFIX) for name in shipped_validations()]
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
