"""Series are compared with a reference along the way, at an event, and at the end."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.table.comparison import comparison
from hairpipe.values.table import table_of_columns

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
