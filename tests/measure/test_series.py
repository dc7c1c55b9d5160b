"""Events in a series, where they are known."""

import numpy as np
import pytest
from hairpipe.nodes.measure_event import measure_event

from hairpipe.data.table import table_of_columns
from hairpipe.errors import BadInput
from hairpipe.measure.series import crossings, period

X = np.linspace(0.0, 10.0, 2001)
TABLE = table_of_columns({"time [s]": X, "tip [m]": np.exp(-0.1 * X) * np.sin(2 * np.pi * X / 1.25) + 3.0})


def test_crossings_are_found_between_points():
    np.testing.assert_allclose(crossings(np.array([0.0, 1, 2, 3]), np.array([0.0, 2, 2, -2]), 1.0), [0.5, 2.25])
    np.testing.assert_allclose(crossings(X, np.cos(X), 0.0), np.pi * np.array([0.5, 1.5, 2.5]), atol=1e-5)
    assert len(crossings(X, X * 0, 1.0)) == 0


def test_a_damped_swing_has_its_period():
    assert period(X, TABLE.numbers["tip [m]"]) == pytest.approx(1.25, rel=1e-3)
    assert np.isnan(period(X[:50], np.sin(X[:50])))


def test_the_node_sets_it_beside_theory():
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
