"""Charts of lines, maps and densities: the same bytes again, and what is drawn is what was asked for."""

import importlib

import matplotlib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments import chart
from hairpipe.graphs.experiments.chart.densities import draw_densities
from hairpipe.graphs.experiments.chart.lines import CLOSEST, Columns, draw_table, lines_of, spread
from hairpipe.graphs.experiments.chart.maps import MapColumns, draw_maps, formatted, shortest
from hairpipe.values.table import table_of_rows

ROWS = [(case, step, error * step**2, 0.5) for case, error in (("ours", 1.0), ("theirs", 9.0)) for step in (0.1, 0.2)]
TABLE = table_of_rows(["scheme", "step [s]", "error [m]", "spread [m]"], [*ROWS, ("failed", 0.2, np.nan, np.inf)])


def drawn(path, **changes) -> bytes:
    names = {name: changes.pop(name) for name in ("x", "y", "series") if name in changes}
    draw_table(path, TABLE, Columns(**{"x": "step [s]", "y": ["error [m]"], "series": "scheme"} | names), **changes)
    return path.read_bytes()


def test_the_same_table_gives_the_same_bytes_whatever_the_user_likes(tmp_path):
    first = drawn(tmp_path / "a.png")
    with matplotlib.rc_context({"font.size": 20, "axes.facecolor": "red", "savefig.dpi": 30, "lines.linewidth": 9}):
        assert drawn(tmp_path / "b.png") == first
        assert matplotlib.rcParams["font.size"] == 20, "what the user likes is left alone"
    assert not {b"tIME", b"tEXt", b"iTXt"} & {first[n : n + 4] for n in range(len(first) - 3)}


def test_a_picture_has_its_size_and_every_choice_shows(tmp_path):
    with Image.open(tmp_path / "a.png" if drawn(tmp_path / "a.png", size=(640, 360)) else "") as image:
        assert image.size == (640, 360)
    plain = drawn(tmp_path / "a.png")
    for change in (
        {"series": None},
        {"y": ["spread [m]"]},
        {"y": ["error [m]", "spread [m]"]},
        {"x": "scheme"},
        {"scales": ("linear", "log")},
        {"scales": ("log", "linear")},
        {"title": "t"},
        {"label": "l"},
        {"levels": [0.1]},
    ):
        assert drawn(tmp_path / "b.png", **change) != plain, change


def test_rows_are_split_into_lines_in_their_order():
    lines = lines_of(TABLE, Columns("step [s]", ["error [m]"], "scheme"))
    assert [line.label for line in lines] == ["ours", "theirs", "failed"]
    np.testing.assert_array_equal(lines[1].y, [9.0 * 0.1**2, 9.0 * 0.2**2])
    both = lines_of(TABLE, Columns("scheme", ["error [m]", "spread [m]"], "step [s]"))
    assert [line.label for line in both] == [f"{s}, {n}" for s in ("0.1", "0.2") for n in ("error [m]", "spread [m]")]
    assert both[0].x == ["ours", "theirs"]


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=40))
def test_labels_keep_their_distance_and_stay_inside(wanted):
    places = spread(wanted)
    closest = min(CLOSEST, 1.0 / max(len(wanted) - 1, 1))
    assert min(places) >= -1e-12 and max(places) <= 1 + 1e-12
    assert (np.diff(np.sort(places)) >= closest - 1e-12).all()
    if (np.diff(np.sort(wanted)) >= closest).all():
        np.testing.assert_allclose(places, wanted, atol=1e-12)


def test_columns_that_are_not_there_are_named(tmp_path):
    for change, reported in (
        ({"x": "step"}, "no column 'step'"),
        ({"y": ["erorr"]}, "no column"),
        ({"series": "x"}, "no column 'x'"),
    ):
        with pytest.raises(BadInput, match=reported):
            drawn(tmp_path / "a.png", **change)
    with pytest.raises(BadInput, match="'scheme' holds texts"):
        drawn(tmp_path / "a.png", y=["scheme"])


NAMES = ["case", "step [s]", "motion", "error [%]", "failed"]
CELLS = [
    ("ours", 1 / 24, "rest", 0.02, ""),
    ("ours", 1 / 240, "rest", 3.0, "stretch, energy"),
    ("ours", 1 / 24, "swing", np.nan, "not run"),
    ("theirs", 1 / 240, "swing", np.nan, "NaN"),
]


def drawn_map(path, rows, limits=(0.01, 100.0), **changes):
    columns = {"panels": "case", "x": "step [s]", "y": "motion", "value": "error [%]", "marks": "failed"}
    draw_maps(
        path, table_of_rows(NAMES, rows), MapColumns(**columns | changes), limits=limits, across=2, size=(900, 500)
    )
    return path.read_bytes()


@pytest.mark.slow
def test_every_cell_shows_and_bytes_repeat(tmp_path):
    plain = drawn_map(tmp_path / "a.png", CELLS)
    assert drawn_map(tmp_path / "b.png", CELLS) == plain
    for n, row in enumerate(CELLS):
        other = [*CELLS[:n], (*row[:3], 7.0, ""), *CELLS[n + 1 :]]
        assert drawn_map(tmp_path / "b.png", other) != plain, row
    with Image.open(tmp_path / "a.png") as image:
        assert image.size == (900, 500)


def test_a_column_that_is_not_there_is_named(tmp_path):
    with pytest.raises(BadInput, match="no column 'violence'"):
        drawn_map(tmp_path / "a.png", CELLS, y="violence")


@pytest.mark.parametrize("limits", [(100.0, 0.01), (1.0, 1.0), (0.0, 1.0)])
def test_limits_that_do_not_ascend_are_refused(tmp_path, limits):
    with pytest.raises(BadInput, match=r"limits = \["):
        drawn_map(tmp_path / "a.png", CELLS, limits)


def test_steps_are_written_as_fractions():
    assert [formatted(step) for step in (1 / 24, 1e-4, 0.5, 1.0)] == ["1/24", "1/10000", "1/2", "1"]
    assert [formatted(share) for share in (0.7, 0.6, 0.4, 0.3, 0.15)] == ["0.7", "0.6", "0.4", "0.3", "0.15"]


def test_numbers_fit_into_a_cell():
    assert [shortest(value) for value in (3e-4, 0.034, 1.234, 9.96, 88.4)] == ["<.01", "0.034", "1.2", "10", "88"]


def drawn_density(path, nodes):
    """A picture of a density that rises evenly, known at so many nodes along each side."""
    ramp = np.linspace(0.0, 1.0, nodes)
    draw_densities(path, [("ramp", ramp[:, None] + ramp, (0.0, 0.1, 0.0, 0.1))], size=(500, 400))
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"), float)


def test_a_density_that_rises_evenly_looks_the_same_from_few_nodes_and_from_many(tmp_path):
    coarse, fine = drawn_density(tmp_path / "coarse.png", 4), drawn_density(tmp_path / "fine.png", 64)
    assert coarse.shape == (400, 500, 3)
    assert np.abs(coarse - fine).max() < 12.0
    assert (fine[200, :, 1] < 250.0).any()


def test_no_hair_is_an_empty_panel(tmp_path):
    draw_densities(tmp_path / "none.png", [("none", np.zeros((0, 0)), (0.0, 0.0, 0.0, 0.0))], size=(500, 400))
    with Image.open(tmp_path / "none.png") as image:
        assert image.size == (500, 400)


def test_the_extra_is_named(monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(importlib.util, "find_spec", lambda name: None)
        with pytest.raises(BadInput, match=r"matplotlib is not installed.*hairpipe\[experiments\]"):
            importlib.reload(chart)
    importlib.reload(chart)
