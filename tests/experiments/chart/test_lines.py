"""Charts: the same bytes for the same table, whoever draws it, and what is drawn is what was asked for."""

import matplotlib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.chart.lines import CLOSEST, Columns, draw_table, lines_of, spread
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
