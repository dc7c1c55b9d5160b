"""Lines cover what they should, hide behind what is before them, and strands are smooth curves."""

import numpy as np
import pytest

from hairpipe.render.raster.lines import SKIN, draw_line, draw_strands


def blank(size: int = 100) -> tuple[np.ndarray, np.ndarray]:
    """A black film with nothing on it."""
    return np.zeros((size, size, 3), np.float32), np.full((size, size), np.inf)


def line(start: tuple[float, float], end: tuple[float, float], width: float, depth: float = 1.0) -> np.ndarray:
    """Two ends of a white line."""
    return np.array([[*place, depth, width, 1.0, 1.0, 1.0] for place in (start, end)])


@pytest.mark.parametrize("width", [0.03, 0.4, 1.0, 2.7])
@pytest.mark.parametrize("angle", np.radians([0.0, 17.0, 44.0, 46.0, 90.0, 133.0, 180.0, 250.0]))
def test_coverage_sums_to_width_times_length(width: float, angle: float) -> None:
    film, depth = blank()
    reach = 40.0 * np.array([np.cos(angle), np.sin(angle)])
    a, b = line(tuple(50.3 - reach), tuple(50.3 + reach), width)
    draw_line(film, depth, a, b)
    assert film[..., 0].sum() == pytest.approx(width * 80.0, rel=0.02)
    assert film.max() <= 1.0 + 1e-6


def test_a_horizontal_line_covers_its_rows_by_their_share() -> None:
    film, depth = blank(10)
    draw_line(film, depth, *line((1.0, 4.75), (7.0, 4.75), 1.0))
    assert film[4, 1:7, 0] == pytest.approx(0.75) and film[5, 1:7, 0] == pytest.approx(0.25)
    assert film[..., 0].sum() == pytest.approx(6.0)


def test_a_line_cut_in_two_is_the_same_line() -> None:
    whole, depth = blank()
    draw_line(whole, depth, *line((3.2, 10.0), (90.7, 60.0), 0.8))
    cut, _ = blank()
    middle = 3.2 + 0.37 * 87.5, 10.0 + 0.37 * 50.0
    draw_line(cut, depth, *line((3.2, 10.0), middle, 0.8))
    draw_line(cut, depth, *line(middle, (90.7, 60.0), 0.8))
    assert cut == pytest.approx(whole, abs=1e-6)


@pytest.mark.parametrize(("depth_of_line", "visible"), [(1.0, True), (2.0 + 0.5 * SKIN, True), (2.1, False)])
def test_the_body_hides_what_is_behind_it(depth_of_line: float, visible: bool) -> None:
    film, depth = blank(10)
    depth[:] = 2.0
    draw_line(film, depth, *line((0.0, 5.5), (10.0, 5.5), 1.0, depth_of_line))
    assert (film[5, :, 0] > 0).all() == visible and film.any() == visible


@pytest.mark.parametrize("far", [1e7, 1e30, 1e300])
def test_lines_far_off_the_film_end_soon(far: float) -> None:
    film, depth = blank(10)
    draw_line(film, depth, *line((5.5, 5.5), (far, 5.5), 0.5))
    draw_line(film, depth, *line((-far, far), (-far, -far), 0.5))
    assert film[5, 6:, 0] == pytest.approx(0.5)


def paint(points: np.ndarray, colours: np.ndarray, width: float) -> np.ndarray:
    """Draw strands (S, n, 3), each of one colour (S, 3), over black."""
    film, depth = blank()
    count, each, _ = points.shape
    offsets = np.arange(0, count * each + 1, each, dtype=np.int32)
    draw_strands(film, depth, points.reshape(-1, 3), offsets, np.repeat(colours, each, axis=0), width)
    return film


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_the_nearer_strand_lies_over_the_farther(order: list[int]) -> None:
    along = np.linspace(5.0, 95.0, 10)
    red = np.stack([along, np.full(10, 50.0), np.full(10, 1.0)], axis=1)
    blue = np.stack([np.full(10, 50.0), along, np.full(10, 1.1)], axis=1)
    film = paint(np.stack([red, blue])[order], np.array([[1.0, 0, 0], [0, 0, 1]])[order], 6.0)
    assert film[49:51, 49:51] == pytest.approx(np.broadcast_to([1.0, 0, 0], (2, 2, 3)), abs=1e-6)
    assert film[30, 50, 2] > 0.9 and film[50, 30, 0] > 0.9


def test_a_strand_is_a_smooth_curve_through_its_points() -> None:
    turn = np.linspace(0.0, np.pi, 7)
    arc = np.stack([50 - 40 * np.cos(turn), 80 - 40 * np.sin(turn), np.ones(7)], axis=1)
    film = paint(arc[None], np.ones((1, 3)), 1.0)
    rows, columns = np.mgrid[0.5:100, 0.5:100]
    away, cover = np.hypot(columns - 50, rows - 80), film[..., 0] * (rows < 60)
    # along the arc, less its pinned ends, the middle of the line; the chords would lie up to 1.4 pixels inside
    for start in np.radians(np.arange(30, 150, 5)):
        sector = cover * (np.abs(np.arctan2(80 - rows, columns - 50) - start) < np.radians(2.5))
        assert (sector * away).sum() / sector.sum() == pytest.approx(40.0, abs=0.25)


def test_strands_behind_the_eye_are_not_drawn() -> None:
    points = np.array([[[10.0, 50, 1], [50, 50, -0.2], [90, 50, -1]]])
    assert not paint(points, np.ones((1, 3)), 5.0).any()
