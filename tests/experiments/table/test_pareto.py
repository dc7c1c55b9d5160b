"""What is on the front, and how variants come into one table."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.collect_variants import collect_variants
from hairpipe.graphs.experiments.table.pareto import on_front
from hairpipe.values.table import table_of_rows

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
