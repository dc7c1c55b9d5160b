"""A rope that slips on a cylinder has the ratio of Euler and Eytelwein."""

import numpy as np
import pytest
from hairpipe.nodes.measure_capstan import measure_capstan

from hairpipe.data.table import table_of_columns


def test_the_ratio_of_a_slipping_rope_is_the_limit():
    turned = np.concatenate([np.zeros(5), np.linspace(0.0, 180.0, 201), np.full(5, 180.0)])
    pull = 7.0 * np.exp(0.4 * np.radians(turned))
    count = len(turned)
    columns = {"turned [deg]": np.tile(turned, 3), "tension [uN]": np.concatenate([pull, pull[::-1], pull * 0 + 3.0])}
    times, strands = np.repeat([0.0, 0.0, 0.5], count), np.repeat([0, 1, 0], count)
    table = measure_capstan(table_of_columns({"time [s]": times, "strand": strands, **columns}), friction=0.4)
    assert table["time [s]"].tolist() == [0.0, 0.0, 0.5] and table["strand"].tolist() == [0, 1, 0]
    limit = np.exp(0.4 * 0.9 * np.pi)
    assert table["wrapped [deg]"] == pytest.approx([162.0] * 3, abs=1e-6)
    assert table["limit of friction [1]"] == pytest.approx([limit] * 3)
    assert table["tension ratio [1]"] == pytest.approx([limit, limit, 1.0], rel=1e-3)


def test_what_does_not_pull_has_no_ratio():
    columns = {
        "time [s]": [0.0] * 3,
        "strand": [0] * 3,
        "turned [deg]": [0.0, 5.0, 9.0],
        "tension [uN]": [1.0, 0.0, -1],
    }
    assert measure_capstan(table_of_columns(columns))["tension ratio [1]"].tolist() == [np.inf]
