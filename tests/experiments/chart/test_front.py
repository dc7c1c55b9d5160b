"""Fronts: every point shows, and the same table gives the same bytes."""

import numpy as np
import pytest
from PIL import Image

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.chart.front import Columns, draw_front, limits_of
from hairpipe.graphs.experiments.chart.labels import Box, candidates
from hairpipe.values.table import table_of_rows

NAMES = ["case", "group", "seconds", "error [%]", "failed", "front"]
ROWS = [
    ("fine", "step", 1e-2, 0.1, "", 1),
    ("coarse", "step", 1e-3, 2.0, "", 1),
    ("slow", "scheme", 2e-2, 3.0, "", 0),
    ("wild", "scheme", 5e-3, 900.0, "stretched at frame 3", 0),
    ("lost", "scheme", 2e-3, np.nan, "not finite at frame 2", 0),
]
FAILED = np.array([217, 72, 43])
COLUMNS = Columns("seconds", "error [%]", "case", "group", "failed", "front")


def drawn(path, rows, columns=COLUMNS, **changes):
    draw_front(path, table_of_rows(NAMES, rows), columns, size=(900, 600), **changes)
    return path.read_bytes()


@pytest.mark.slow
def test_every_point_shows_and_bytes_repeat(tmp_path):
    plain = drawn(tmp_path / "a.png", ROWS)
    assert drawn(tmp_path / "b.png", ROWS) == plain
    for n in range(len(ROWS)):
        assert drawn(tmp_path / "b.png", ROWS[:n] + ROWS[n + 1 :]) != plain, ROWS[n]
    for n, row in enumerate(ROWS):
        assert drawn(tmp_path / "b.png", [*ROWS[:n], (*row[:5], 1 - row[5]), *ROWS[n + 1 :]]) != plain or row[4]
    assert drawn(tmp_path / "b.png", ROWS, joined=("step",)) != plain
    with Image.open(tmp_path / "a.png") as image:
        assert image.size == (900, 600)


def test_failed_points_are_red_and_do_not_stretch_the_axes(tmp_path):
    drawn(tmp_path / "a.png", ROWS)
    drawn(tmp_path / "b.png", ROWS[:3])
    assert red_in(tmp_path / "a.png") > 100 and red_in(tmp_path / "b.png") == 0
    nearer = [*ROWS[:3], (*ROWS[3][:3], 9e7, *ROWS[3][4:]), ROWS[4]]
    assert drawn(tmp_path / "b.png", nearer) == (tmp_path / "a.png").read_bytes()


def red_in(path):
    """Count the pixels in the colour of what failed."""
    with Image.open(path) as image:
        return np.sum(np.abs(np.asarray(image)[:, :, :3].astype(int) - FAILED).sum(axis=2) < 10)


@pytest.mark.slow
def test_intervals_are_bars_and_what_is_below_the_floor_stands_on_it(tmp_path):
    names = [*NAMES, "low", "high", "floor"]
    columns = COLUMNS._replace(low="low", high="high", floor="floor")

    def image(name, *ends, error=0.1):
        rows = [(*ROWS[0][:3], error, *ROWS[0][4:], *ends), (*ROWS[1], 1.5, 2.5, ends[2]), (*ROWS[4], *[np.nan] * 3)]
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
        rows = [(*row, spread) for row, spread in zip(ROWS[:2], spreads, strict=True)]
        columns = COLUMNS._replace(spread="spread")
        draw_front(tmp_path / name, table_of_rows([*NAMES, "spread"], rows), columns, size=(900, 600))
        return (tmp_path / name).read_bytes()

    plain = drawn(tmp_path / "a.png", ROWS[:2])
    assert image("b.png", 0.81, 1.24) == image("b.png", np.nan, 1.0) == plain
    assert len({plain, image("b.png", 0.66, 1.0), image("b.png", 1.0, 0.66), image("b.png", 1.0, 1.3)}) == 4


def test_exact_points_are_not_failures(tmp_path):
    exact = ("exact", "step", 1e-1, 0.0, "", 1)
    plain, shown = (drawn(tmp_path / name, rows) for name, rows in (("a.png", ROWS[:3]), ("b.png", [*ROWS[:3], exact])))
    assert shown != plain and red_in(tmp_path / "b.png") == 0
    drawn(tmp_path / "b.png", [exact])
    assert red_in(tmp_path / "b.png") == 0


def test_zeros_do_not_stretch_the_axes():
    low, high = limits_of(np.array([0.0, 1e-3, 1e-1]), np.array([2.0, 0.0, 8.0]))
    assert (low > (5e-4, 1.0)).all() and (low < (1e-3, 2.0)).all() and (high > (1e-1, 8.0)).all()


def test_names_may_be_numbers(tmp_path):
    numbered = [(n, *row[1:]) for n, row in enumerate(ROWS)]
    written = [(str(n), *row[1:]) for n, row in enumerate(ROWS)]
    assert drawn(tmp_path / "a.png", numbered) == drawn(tmp_path / "b.png", written)


def test_undrawable_tables_are_refused(tmp_path):
    with pytest.raises(BadInput, match="no column 'price'"):
        drawn(tmp_path / "a.png", ROWS, COLUMNS._replace(x="price"))
    with pytest.raises(BadInput, match="no variant has a cost and an error"):
        drawn(tmp_path / "a.png", ROWS[3:])


def test_labels_are_next_to_their_points():
    point = np.array([50.0, 50.0])
    for box, _ in candidates("a name", point, Box(0, 0, 100, 100)):
        assert not (box.left < 48 < 52 < box.right and box.low < 48 < 52 < box.high)
