"""Charts: the same bytes again, and what is drawn is what was asked for."""

import importlib

import matplotlib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from hairpipe.engine import Frames, Time, Workspace
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments import chart
from hairpipe.graphs.experiments.chart.densities import draw_densities
from hairpipe.graphs.experiments.chart.front import Columns as FrontColumns
from hairpipe.graphs.experiments.chart.front import draw_front, limits_of
from hairpipe.graphs.experiments.chart.labels import Box, candidates
from hairpipe.graphs.experiments.chart.lines import CLOSEST, Columns, draw_table, lines_of, spread
from hairpipe.graphs.experiments.chart.maps import MapColumns, draw_maps, formatted, shortest
from hairpipe.graphs.experiments.chart.poses import Panel, Pose, draw_poses, grid_for, panels_of, pieces_of
from hairpipe.graphs.experiments.nodes.plot_strand import plot_strand
from hairpipe.values import Strands
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


FPS = 25.0
FRAMES = range(1001, 1012)


def strands(frame: int) -> Strands:
    down = np.linspace([0, 0, 0], [0.01 * (frame - 1001), -0.1, 0.02], 8)
    points = np.concatenate([down, down + np.array([0.0, 0.0, 0.05])]).astype(np.float32)
    return Strands(points, np.zeros_like(points), np.array([0, 8, 16], np.int32), 80e-6)


SHOT = Frames(tuple(FRAMES), strands)


def times(**changes) -> list[float]:
    chosen = {"count": 3, "moments": (), "strands": (), "cases": ()} | changes
    (panel,) = panels_of([SHOT], FPS, **chosen)
    return [round(pose.time * FPS) for pose in panel.poses]


def test_frames_are_spread_evenly_or_named():
    assert times() == [0, 5, 10] and times(count=1) == [0] and times(count=99) == list(range(11))
    assert times(moments=(1003, 1007, 2000)) == [2, 6]
    assert times(moments=(7,)) == [0, 5, 10], "a run of other frames shows those"


def test_strands_are_all_or_those_named():
    (panel,) = panels_of([SHOT], FPS, 2, (), (1,), ("one",))
    assert panel.name == "one" and len(panel.poses[1].strands) == 1
    np.testing.assert_allclose(panel.poses[1].strands[0], strands(1011).points[8:], rtol=1e-7)
    for strand in (2, -1):
        with pytest.raises(BadInput, match="from 0 to 1"):
            panels_of([SHOT], FPS, 2, (), (strand,), ())
    with pytest.raises(BadInput, match="2 names for 1"):
        panels_of([SHOT], FPS, 2, (), (), ("one", "two"))


def test_pieces_are_the_segments_with_a_bit_of_their_neighbours():
    points = np.cumsum(np.random.default_rng(2).normal(size=(6, 3)), axis=0)
    pieces = pieces_of(points)
    np.testing.assert_array_equal(pieces[:, 1], points[:-1])
    np.testing.assert_array_equal(pieces[:, 2], points[1:])
    np.testing.assert_array_equal(pieces[[0, -1], [0, 3]], points[[0, -1]])
    on = (pieces[1:, 0] - points[1:-1]) / (points[:-2] - points[1:-1])
    assert np.ptp(on) < 1e-9 and 0 < on.min() < 0.5


def test_the_strand_in_front_hides_the_one_behind(tmp_path):
    """A cross of two strands: its middle has the colour of the pose's strand; the rim cuts the one behind."""
    across, upright = np.linspace([-1, 0, 0], [1, 0, 0], 5), np.linspace([0, -1, 0.0], [0, 1, 0.0], 5)
    images = []
    for depth in (-0.1, 0.1):
        draw_poses(
            tmp_path / "a.png",
            [Panel("", [Pose(0.0, [across, upright + np.array([0, 0, depth])])])],
            "xy",
            size=(600, 600),
        )
        with Image.open(tmp_path / "a.png") as image:
            images.append(np.asarray(image.convert("L")).astype(int))
    differs = np.argwhere(images[0] != images[1])
    assert 4 < len(differs) < 400, "only the crossing differs"
    assert np.ptp(differs, axis=0).max() < 30


@pytest.mark.parametrize("apart", [(0.0, 0.0), (0.0, -0.02), (0.02, 0.0)])
def test_the_node_draws_the_same_bytes(tmp_path, apart):
    def draw() -> bytes:
        return plot_strand(
            (SHOT, SHOT), Time(1001, FPS), Workspace(tmp_path), apart=apart, width=500, height=300
        ).path.read_bytes()

    assert draw() == draw()
    with Image.open(tmp_path / "poses.png") as image:
        assert image.size == (500, 300) and len(image.convert("RGB").getcolors(100_000) or ()) > 50


def test_panels_stand_so_that_they_are_large():
    wide, high = np.array([1.0, 0.1]), np.array([0.1, 1.0])
    assert grid_for(3, wide, (1000, 1000)) == (3, 1) and grid_for(3, high, (1000, 1000)) == (1, 3)
    assert grid_for(4, np.array([1.0, 1.0]), (1000, 1000)) == (2, 2)
    assert grid_for(1, np.array([1.0, 0.0]), (1000, 1000)) == (1, 1)


def test_panels_may_be_fewer_than_places(tmp_path):
    panels = [Panel(name, [Pose(0.0, [np.eye(3)])]) for name in "abc"]
    draw_poses(tmp_path / "a.png", panels, "xy", apart=(0.1, 0.0), size=(600, 600))
    assert (tmp_path / "a.png").stat().st_size > 1000


VARIANTS = ["case", "group", "seconds", "error [%]", "failed", "front"]
POINTS = [
    ("fine", "step", 1e-2, 0.1, "", 1),
    ("coarse", "step", 1e-3, 2.0, "", 1),
    ("slow", "scheme", 2e-2, 3.0, "", 0),
    ("wild", "scheme", 5e-3, 900.0, "stretched at frame 3", 0),
    ("lost", "scheme", 2e-3, np.nan, "not finite at frame 2", 0),
]
FAILED = np.array([217, 72, 43])
COLUMNS = FrontColumns("seconds", "error [%]", "case", "group", "failed", "front")


def drawn_front(path, rows, columns=COLUMNS, **changes):
    draw_front(path, table_of_rows(VARIANTS, rows), columns, size=(900, 600), **changes)
    return path.read_bytes()


@pytest.mark.slow
def test_every_point_shows_and_bytes_repeat(tmp_path):
    plain = drawn_front(tmp_path / "a.png", POINTS)
    assert drawn_front(tmp_path / "b.png", POINTS) == plain
    for n in range(len(POINTS)):
        assert drawn_front(tmp_path / "b.png", POINTS[:n] + POINTS[n + 1 :]) != plain, POINTS[n]
    for n, row in enumerate(POINTS):
        assert (
            drawn_front(tmp_path / "b.png", [*POINTS[:n], (*row[:5], 1 - row[5]), *POINTS[n + 1 :]]) != plain or row[4]
        )
    assert drawn_front(tmp_path / "b.png", POINTS, joined=("step",)) != plain
    with Image.open(tmp_path / "a.png") as image:
        assert image.size == (900, 600)


def test_failed_points_are_red_and_do_not_stretch_the_axes(tmp_path):
    drawn_front(tmp_path / "a.png", POINTS)
    drawn_front(tmp_path / "b.png", POINTS[:3])
    assert red_in(tmp_path / "a.png") > 100 and red_in(tmp_path / "b.png") == 0
    nearer = [*POINTS[:3], (*POINTS[3][:3], 9e7, *POINTS[3][4:]), POINTS[4]]
    assert drawn_front(tmp_path / "b.png", nearer) == (tmp_path / "a.png").read_bytes()


def red_in(path):
    """Count the pixels in the colour of what failed."""
    with Image.open(path) as image:
        return np.sum(np.abs(np.asarray(image)[:, :, :3].astype(int) - FAILED).sum(axis=2) < 10)


@pytest.mark.slow
def test_intervals_are_bars_and_what_is_below_the_floor_stands_on_it(tmp_path):
    names = [*VARIANTS, "low", "high", "floor"]
    columns = COLUMNS._replace(low="low", high="high", floor="floor")

    def image(name, *ends, error=0.1):
        rows = [
            (*POINTS[0][:3], error, *POINTS[0][4:], *ends),
            (*POINTS[1], 1.5, 2.5, ends[2]),
            (*POINTS[4], *[np.nan] * 3),
        ]
        draw_front(tmp_path / name, table_of_rows(names, rows), columns, size=(900, 600))
        return (tmp_path / name).read_bytes()

    plain = image("a.png", 0.5, 1.2, 0.6)
    assert image("b.png", 0.5, 1.2, 0.6, error=0.3) == plain
    assert (
        len({plain, image("b.png", 0.7, 1.2, 0.6), image("b.png", 0.5, 1.1, 0.6), image("b.png", 0.5, 1.2, 0.8)}) == 4
    )
    assert image("b.png", -1.0, 1.2, 0.6) == image("c.png", 0.0, 1.2, 0.6)  # cut at the lower edge
    assert image("b.png", np.nan, np.nan, 0.6) != plain


def test_a_spread_that_is_not_near_that_of_the_reference_is_written(tmp_path):
    def image(name, *spreads):
        rows = [(*row, spread) for row, spread in zip(POINTS[:2], spreads, strict=True)]
        columns = COLUMNS._replace(spread="spread")
        draw_front(tmp_path / name, table_of_rows([*VARIANTS, "spread"], rows), columns, size=(900, 600))
        return (tmp_path / name).read_bytes()

    plain = drawn_front(tmp_path / "a.png", POINTS[:2])
    assert image("b.png", 0.81, 1.24) == image("b.png", np.nan, 1.0) == plain
    assert len({plain, image("b.png", 0.66, 1.0), image("b.png", 1.0, 0.66), image("b.png", 1.0, 1.3)}) == 4


def test_exact_points_are_not_failures(tmp_path):
    exact = ("exact", "step", 1e-1, 0.0, "", 1)
    plain, shown = (
        drawn_front(tmp_path / name, rows) for name, rows in (("a.png", POINTS[:3]), ("b.png", [*POINTS[:3], exact]))
    )
    assert shown != plain and red_in(tmp_path / "b.png") == 0
    drawn_front(tmp_path / "b.png", [exact])
    assert red_in(tmp_path / "b.png") == 0


def test_zeros_do_not_stretch_the_axes():
    low, high = limits_of(np.array([0.0, 1e-3, 1e-1]), np.array([2.0, 0.0, 8.0]))
    assert (low > (5e-4, 1.0)).all() and (low < (1e-3, 2.0)).all() and (high > (1e-1, 8.0)).all()


def test_names_may_be_numbers(tmp_path):
    numbered = [(n, *row[1:]) for n, row in enumerate(POINTS)]
    written = [(str(n), *row[1:]) for n, row in enumerate(POINTS)]
    assert drawn_front(tmp_path / "a.png", numbered) == drawn_front(tmp_path / "b.png", written)


def test_undrawable_tables_are_refused(tmp_path):
    with pytest.raises(BadInput, match="no column 'price'"):
        drawn_front(tmp_path / "a.png", POINTS, COLUMNS._replace(x="price"))
    with pytest.raises(BadInput, match="no variant has a cost and an error"):
        drawn_front(tmp_path / "a.png", POINTS[3:])


def test_labels_are_next_to_their_points():
    point = np.array([50.0, 50.0])
    for box, _ in candidates("a name", point, Box(0, 0, 100, 100)):
        assert not (box.left < 48 < 52 < box.right and box.low < 48 < 52 < box.high)
