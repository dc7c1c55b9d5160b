"""Events in a series, where they are known."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.measure_event import measure_event
from hairpipe.graphs.experiments.nodes.summarize_tables import summarize_tables
from hairpipe.graphs.experiments.table.series import crossings, period
from hairpipe.values.table import table_of_columns

X = np.linspace(0.0, 10.0, 2001)
TABLE = table_of_columns({"time [s]": X, "tip [m]": np.exp(-0.1 * X) * np.sin(2 * np.pi * X / 1.25) + 3.0})


def test_crossings_are_found_between_points():
    np.testing.assert_allclose(crossings(np.array([0.0, 1, 2, 3]), np.array([0.0, 2, 2, -2]), 1.0), [0.5, 2.25])
    np.testing.assert_allclose(crossings(X, np.cos(X), 0.0), np.pi * np.array([0.5, 1.5, 2.5]), atol=1e-5)
    assert len(crossings(X, X * 0, 1.0)) == 0


def test_a_damped_swing_has_its_period():
    assert period(X, TABLE.numbers["tip [m]"]) == pytest.approx(1.25, rel=1e-3)
    assert np.isnan(period(X[:50], np.sin(X[:50]))) and np.isnan(period(X[:0], X[:0]))


def test_node_compares_with_theory():
    found = measure_event(TABLE, what="period", x="time [s]", y="tip [m]", first=2.0, theory=1.25)
    assert found["measured"][0] == pytest.approx(1.25, rel=2e-3) and abs(found["error [%]"][0]) < 0.2
    found = measure_event(TABLE, what="crossing", x="time [s]", y="tip [m]", level=3.0, first=0.1, theory=0.5)
    assert (found["measured"][0], found["error [%]"][0]) == (
        pytest.approx(0.625, rel=1e-4),
        pytest.approx(25, rel=1e-3),
    )
    found = measure_event(TABLE, what="crossing", x="time [s]", y="tip [m]", level=9.0, last=5.0, theory=0.5)
    assert np.isnan(found["measured"][0])
    with pytest.raises(BadInput, match="'tip'"):
        measure_event(TABLE, what="period", x="time [s]", y="tip", theory=1.0)


def test_tables_are_summed_up_against_what_was_varied():
    tables = tuple(table_of_columns({"a": np.array([1.0, k, np.nan]), "b": [3, 2, k]}) for k in (5, -4))
    for take, a, b in (("last", (5, -4), (5, -4)), ("largest", (5, 1), (5, 3)), ("smallest", (1, -4), (2, -4))):
        found = summarize_tables(tables, columns=("a", "b"), take=take, against=(1e9, 2e9), name="young [Pa]")
        assert found.names == ("young [Pa]", f"{take} a", f"{take} b")
        assert list(found.rows()) == [(1e9, a[0], b[0]), (2e9, a[1], b[1])]
    mean = summarize_tables(tables, columns=("a",), take="mean", against=(1, 2), name="n")
    assert mean["mean a"].tolist() == [3.0, -1.5]
    for change, reported in (({"against": (1,)}, "1 values for 2"), ({"columns": ("c",)}, "'c'")):
        with pytest.raises(BadInput, match=reported):
            summarize_tables(tables, **{"columns": ("a",), "against": (1, 2), "name": "n"} | change)
