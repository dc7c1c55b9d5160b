"""Rows that are picked."""

import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.table.rows import select
from hairpipe.values.table import table_of_rows

ONE = table_of_rows(["name", "length [m]"], [("a", 0.3), ("b", 0.1)])
OTHER = table_of_rows(["name", "length [m]"], [("c", 0.1)])


def test_rows_with_a_value_are_kept_in_order():
    assert list(select([ONE, OTHER], ["x", "y"], "length [m]", 0.1).rows()) == [("x", "b", 0.1), ("y", "c", 0.1)]


def test_unknown_rows_are_refused():
    for column, value, reported in (
        ("size", 1.0, "no column"),
        ("name", 1.0, "no column"),
        ("length [m]", 2.0, "no row"),
    ):
        with pytest.raises(BadInput, match=reported):
            select([ONE], [], column, value)
