"""What errors say about cost and order."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.studies.integrators.cost import order_of, solves_for

STEPS = 0.1 * 0.5 ** np.arange(6.0)


def test_order_is_that_of_the_power_whatever_lies_beyond_it():
    errors = 1000 * STEPS**2
    assert order_of(STEPS, errors) == pytest.approx(2.0)
    lost, rounded = errors.copy(), errors.copy()
    lost[0], rounded[-1] = 60.0, 0.009
    assert order_of(STEPS, lost) == pytest.approx(2.0)
    assert order_of(STEPS[:5], rounded[:5]) == pytest.approx(2.0)
    assert np.isnan(order_of(STEPS[:2], errors[:2]))


def test_solves_are_interpolated_where_the_error_falls_below_a_level_for_good():
    solves, errors = 2 / STEPS, 1000 * STEPS**2
    assert solves_for(1.0, solves, errors) == pytest.approx(2 / np.sqrt(1e-3))
    assert solves_for(20.0, solves, errors) == solves[0]
    assert np.isnan(solves_for(1e-3, solves, errors))
    humped = np.array([0.5, 40.0, 4.0, 0.4, 0.04, 0.004])
    assert solves[2] < solves_for(1.0, solves, humped) < solves[3]
    humped[2] = np.nan
    assert solves_for(1.0, solves, humped) == solves[3]


def test_cost_without_runs_is_unknown():
    assert np.isnan(solves_for(1.0, np.array([]), np.array([])))
