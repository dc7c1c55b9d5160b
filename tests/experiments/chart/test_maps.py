"""Maps: every cell shows, and the same table gives the same bytes."""

import numpy as np
import pytest
from PIL import Image

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.chart.maps import MapColumns, draw_maps, formatted, shortest
from hairpipe.values.table import table_of_rows

NAMES = ["case", "step [s]", "motion", "error [%]", "failed"]
ROWS = [
    ("ours", 1 / 24, "rest", 0.02, ""),
    ("ours", 1 / 240, "rest", 3.0, "stretch, energy"),
    ("ours", 1 / 24, "swing", np.nan, "not run"),
    ("theirs", 1 / 240, "swing", np.nan, "NaN"),
]


def drawn(path, rows, limits=(0.01, 100.0), **changes):
    columns = {"panels": "case", "x": "step [s]", "y": "motion", "value": "error [%]", "marks": "failed"}
    draw_maps(
        path, table_of_rows(NAMES, rows), MapColumns(**columns | changes), limits=limits, across=2, size=(900, 500)
    )
    return path.read_bytes()


@pytest.mark.slow
def test_every_cell_shows_and_bytes_repeat(tmp_path):
    plain = drawn(tmp_path / "a.png", ROWS)
    assert drawn(tmp_path / "b.png", ROWS) == plain
    for n, row in enumerate(ROWS):
        other = [*ROWS[:n], (*row[:3], 7.0, ""), *ROWS[n + 1 :]]
        assert drawn(tmp_path / "b.png", other) != plain, row
    with Image.open(tmp_path / "a.png") as image:
        assert image.size == (900, 500)


def test_a_column_that_is_not_there_is_named(tmp_path):
    with pytest.raises(BadInput, match="no column 'violence'"):
        drawn(tmp_path / "a.png", ROWS, y="violence")


@pytest.mark.parametrize("limits", [(100.0, 0.01), (1.0, 1.0), (0.0, 1.0)])
def test_limits_that_do_not_ascend_are_refused(tmp_path, limits):
    with pytest.raises(BadInput, match=r"limits = \["):
        drawn(tmp_path / "a.png", ROWS, limits)


def test_steps_are_written_as_fractions():
    assert [formatted(step) for step in (1 / 24, 1e-4, 0.5, 1.0)] == ["1/24", "1/10000", "1/2", "1"]
    assert [formatted(share) for share in (0.7, 0.6, 0.4, 0.3, 0.15)] == ["0.7", "0.6", "0.4", "0.3", "0.15"]


def test_numbers_fit_into_a_cell():
    assert [shortest(value) for value in (3e-4, 0.034, 1.234, 9.96, 88.4)] == ["<.01", "0.034", "1.2", "10", "88"]
