"""Tables: rows that are picked, events in series, comparisons, and fronts."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.collect_variants import collect_variants
from hairpipe.graphs.experiments.nodes.measure_event import measure_event
from hairpipe.graphs.experiments.nodes.summarize_tables import summarize_tables
from hairpipe.graphs.experiments.table.comparison import comparison
from hairpipe.graphs.experiments.table.pareto import on_front
from hairpipe.graphs.experiments.table.rows import select
from hairpipe.graphs.experiments.table.series import crossings, period
from hairpipe.values.table import table_of_columns, table_of_rows

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
    assert found["measured"][0] == pytest.approx(0.625, rel=1e-4)
    assert found["error [%]"][0] == pytest.approx(25, rel=1e-3)
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


TIMES = np.linspace(0.0, 2.0, 21)


def ramp(slope: float, times: np.ndarray = TIMES):
    """A table of a straight line through zero."""
    return table_of_columns({"time [s]": times, "y [m]": slope * times})


def compared(measure: str, tables: list, reference, level: float = 0.0, last: float | None = None):
    cases = [f"case {place}" for place in range(len(tables))]
    return comparison(tables, reference, cases, ("time [s]", "y [m]"), measure, level, last).numbers


def test_difference_is_the_largest_relative_to_the_reference():
    found = compared("difference", [ramp(1.1), ramp(0.8)], ramp(1.0), last=1.0)
    assert found["measured"] == pytest.approx([0.1, 0.2]) and found["error [%]"] == pytest.approx([10.0, 20.0])


def test_difference_is_taken_at_the_rows_of_a_coarser_reference():
    curved = table_of_columns({"time [s]": TIMES, "y [m]": TIMES**2})
    coarse = np.array([0.0, 0.7, 1.0])
    found = compared("difference", [curved], table_of_columns({"time [s]": coarse, "y [m]": coarse**2}))
    assert found["measured"] == pytest.approx([0.0])
    assert compared("difference", [ramp(1.5)], ramp(1.0, coarse))["measured"] == pytest.approx([0.5])


def test_crossing_is_of_the_magnitude_and_nan_where_there_is_none():
    found = compared("crossing", [ramp(1.0), ramp(-0.5), ramp(0.1)], ramp(2.0), level=0.5)
    assert found["measured"] == pytest.approx([0.5, 1.0, np.nan], nan_ok=True)
    assert found["error [%]"] == pytest.approx([100.0, 300.0, np.nan], nan_ok=True)


def test_last_keeps_the_sign_and_change_is_relative_to_the_first_row():
    shifted = table_of_columns({"time [s]": TIMES, "y [m]": 3.0 - TIMES})
    assert compared("last", [shifted], ramp(1.0))["measured"] == pytest.approx([1.0])
    hanging = table_of_columns({"time [s]": TIMES, "y [m]": -2.0 - 0.5 * TIMES})
    changed = compared("change", [hanging], shifted)
    assert changed["measured"] == pytest.approx([0.5]) and changed["error [%]"] == pytest.approx([-175.0])


def test_rows_without_a_number_are_omitted():
    gaps = table_of_columns({"time [s]": TIMES, "y [m]": np.where(TIMES > 1.0, np.nan, TIMES)})
    assert compared("last", [ramp(1.0)], gaps)["reference"] == pytest.approx([1.0])


def test_bad_input_is_named():
    with pytest.raises(BadInput, match="1 cases for 2 tables"):
        comparison([ramp(1.0), ramp(1.0)], ramp(1.0), ["one"], ("time [s]", "y [m]"), "last", 0.0, None)
    with pytest.raises(BadInput, match="no column of numbers 'z'"):
        comparison([ramp(1.0)], ramp(1.0), ["one"], ("time [s]", "z"), "last", 0.0, None)
    with pytest.raises(BadInput, match="no row with"):
        comparison([ramp(1.0)], ramp(1.0), ["one"], ("time [s]", "y [m]"), "last", 0.0, -1.0)


ERROR = "strand error [% of length]"


def test_none_on_the_front_is_beaten_and_all_others_are():
    rng = np.random.default_rng(5)
    costs, errors = rng.random((2, 200))
    front = on_front(costs, errors)
    order = np.argsort(costs)
    assert (np.minimum.accumulate(errors[order]) == errors[order]).tolist() == front[order].tolist()


def test_equals_share_the_front_and_what_is_not_finite_is_not_on_it():
    costs, errors = np.array([1.0, 1.0, 2.0, np.nan, 0.5]), np.array([1.0, 1.0, 1.0, 0.1, np.inf])
    assert on_front(costs, errors).tolist() == [True, True, False, False, False]


def test_of_two_whose_intervals_overlap_neither_beats_the_other():
    costs, errors = np.array([1.0, 2.0, 3.0, 4.0]), np.array([2.0, 2.5, 4.0, 2.0])
    low, high = np.array([1.0, 1.5, 3.5, np.nan]), np.array([3.0, 3.5, 4.5, np.nan])
    assert on_front(costs, errors, low, high).tolist() == [True, True, False, False]
    assert on_front(costs, errors).tolist() == [True, False, False, False]
    rng = np.random.default_rng(7)  # by brute force
    costs, low, width = rng.random((3, 40))
    errors, high = low + 0.1 * width, low + 0.2 * width
    beaten = [any(costs[i] <= costs[j] and high[i] < low[j] for i in range(40)) for j in range(40)]
    assert on_front(costs, errors, low, high).tolist() == [not one for one in beaten]


def one_row(**values):
    return table_of_rows(list(values), [list(values.values())])


def test_failed_variants_are_in_the_table_and_not_on_the_front():
    errors = [one_row(**{ERROR: e, "failed": f}) for e, f in ((1.0, ""), (0.1, "not finite at frame 3"), (0.5, ""))]
    costs = [one_row(**{"seconds per frame": s}) for s in (1.0, 1.0, 2.0)]
    table = collect_variants(tuple(errors), tuple(costs), cases=("a", "b", "c"), groups=("x", "x", "y"))
    assert table["case"] == ("a", "b", "c") and table["on the front"].tolist() == [1, 0, 1]
    assert table["failed"] == ("", "not finite at frame 3", "")


def test_of_errors_below_the_floor_the_cheapest_is_on_the_front():
    errors = [one_row(**{ERROR: e, "floor": 0.5, "failed": ""}) for e in (0.1, 0.4, 0.7, 0.3)]
    costs = [one_row(**{"seconds per frame": s}) for s in (4.0, 3.0, 1.0, 2.0)]
    reported = collect_variants(tuple(errors), tuple(costs), cases=("a", "b", "c", "d"), floor="floor")
    assert reported["on the front"].tolist() == [0, 0, 1, 1] and reported["floor"].tolist() == [0.5] * 4
    untold = collect_variants(tuple(errors), tuple(costs), cases=("a", "b", "c", "d"))
    assert untold["on the front"].tolist() == [1, 0, 1, 1]


def test_intervals_below_the_floor_count_as_equal_to_it():
    ends = ((0.1, 0.2, 0.0, 0.3), (0.2, 1.0, 0.6, 1.4), (0.1, 0.3, 0.2, 0.4), (0.05, 2.0, 1.8, 2.2))
    errors = [one_row(error=e, low=a, high=b, floor=0.5, failed="") for _, e, a, b in ends]
    costs = [one_row(**{"seconds per frame": s}) for s in (3.0, 2.0, 1.0, 4.0)]
    reported = collect_variants(
        tuple(errors), tuple(costs), cases=("a", "b", "c", "d"), error="error", floor="floor", low="low", high="high"
    )
    assert reported["on the front"].tolist() == [0, 0, 1, 0]


def test_errors_and_costs_that_do_not_belong_together_are_refused():
    error, cost = one_row(**{ERROR: 1.0, "failed": ""}), one_row(**{"seconds per frame": 1.0})
    with pytest.raises(BadInput, match="2 errors, 1 costs, 2 cases"):
        collect_variants((error, error), (cost,), cases=("a", "b"))
    with pytest.raises(BadInput, match="no column of numbers 'speed'"):
        collect_variants((error,), (cost,), cases=("a",), cost="speed")
