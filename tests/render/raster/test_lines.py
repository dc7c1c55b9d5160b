"""Lines cover what they should, hide behind what is before them, and strands are smooth curves, sorted by depth."""

import numpy as np
import pytest

from hairpipe.render.lines import OPAQUE, ROOT, SKIN, develop_tile, draw_line, draw_strands, lay_curves, make_tile
from hairpipe.values.groom import TAPER

DEPTHS = np.array([-1.0, 0.0, 0.5, 1.0, 1.5]) * SKIN


def line(start: tuple[float, float], end: tuple[float, float], width: float, depth: float = 1.0) -> np.ndarray:
    """Two ends of a white line."""
    return np.array([[*place, depth, width, 1.0, 1.0, 1.0] for place in (start, end)])


def drawn(*lines: np.ndarray, size: int = 100, body: float = np.inf) -> np.ndarray:
    """Draw lines over black, before a body."""
    film, tile = np.zeros((size, size, 3), np.float32), make_tile(np.full((size, size), body))
    for a, b in lines:
        draw_line(tile, a, b)
    develop_tile(film, tile)
    return film


def paint(strands: list[np.ndarray], colours: np.ndarray, width: float, size: int = 100) -> np.ndarray:
    """Draw strands, (n, 3) each, each of one colour, (S, 3), over black."""
    counts = [len(points) for points in strands]
    film, depth = np.zeros((size, size, 3), np.float32), np.full((size, size), np.inf)
    curves = lay_curves(np.concatenate(strands), np.cumsum([0, *counts], dtype=np.int32), width, depth)
    shown = np.repeat(np.asarray(colours, float)[:, None], 2, axis=1)
    draw_strands(film, depth, curves, np.repeat(shown, counts, axis=0))
    return film


@pytest.fixture(scope="module")
def lock() -> tuple[list[np.ndarray], np.ndarray]:
    """400 strands across the film, each at a depth of its own, far more than are seen, and their colours."""
    rng = np.random.default_rng(4)
    ends, depths = rng.uniform(0.0, 100.0, (400, 2, 2)), rng.uniform(1.0, 1.2, 400)
    along = np.linspace(0.0, 1.0, 9)[:, None]
    strands = [np.column_stack([a + along * (b - a), np.full(9, z)]) for (a, b), z in zip(ends, depths, strict=True)]
    return strands, rng.random((400, 3))


@pytest.mark.parametrize("width", [0.03, 0.4, 1.0, 2.7])
@pytest.mark.parametrize("angle", np.radians([0.0, 17.0, 44.0, 46.0, 90.0, 133.0, 180.0, 250.0]))
def test_coverage_sums_to_width_times_length(width: float, angle: float) -> None:
    reach = 40.0 * np.array([np.cos(angle), np.sin(angle)])
    film = drawn(line(tuple(50.3 - reach), tuple(50.3 + reach), width))
    assert film[..., 0].sum() == pytest.approx(width * 80.0, rel=0.02)
    assert film.max() <= 1.0 + 1e-6


def test_a_horizontal_line_covers_its_rows_by_their_share() -> None:
    film = drawn(line((1.0, 4.75), (7.0, 4.75), 1.0), size=10)
    assert film[4, 1:7, 0] == pytest.approx(0.75) and film[5, 1:7, 0] == pytest.approx(0.25)
    assert film[..., 0].sum() == pytest.approx(6.0)


def test_a_line_cut_in_two_is_the_same_line() -> None:
    start, middle, end = (3.2, 10.0), (3.2 + 0.37 * 87.5, 10.0 + 0.37 * 50.0), (90.7, 60.0)
    cut = drawn(line(start, middle, 0.8), line(middle, end, 0.8))
    assert cut == pytest.approx(drawn(line(start, end, 0.8)), abs=1e-6)


@pytest.mark.parametrize(("depth_of_line", "visible"), [(1.0, True), (2.0 + 0.5 * SKIN, True), (2.1, False)])
def test_the_body_hides_what_is_behind_it(depth_of_line: float, visible: bool) -> None:
    film = drawn(line((0.0, 5.5), (10.0, 5.5), 1.0, depth_of_line), size=10, body=2.0)
    assert (film[5, :, 0] > 0).all() == visible and film.any() == visible


@pytest.mark.parametrize("far", [1e7, 1e30, 1e300])
def test_lines_far_off_the_film_end_soon(far: float) -> None:
    film = drawn(line((5.5, 5.5), (far, 5.5), 0.5), line((-far, far), (-far, -far), 0.5), size=10)
    assert film[5, 6:, 0] == pytest.approx(0.5)


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_the_nearer_strand_lies_over_the_farther(order: list[int]) -> None:
    along = np.linspace(5.0, 95.0, 10)
    red = np.stack([along, np.full(10, 50.0), np.full(10, 1.0)], axis=1)
    blue = np.stack([np.full(10, 50.0), along, np.full(10, 1.1)], axis=1)
    film = paint([(red, blue)[k] for k in order], np.array([[1.0, 0, 0], [0, 0, 1]])[order], 6.0)
    assert film[49:51, 49:51] == pytest.approx(np.broadcast_to([1.0, 0, 0], (2, 2, 3)), abs=1e-6)
    assert film[30, 50, 2] > 0.9 and film[50, 30, 0] > 0.9


@pytest.mark.parametrize("segments", [10, 25, 50])
@pytest.mark.parametrize("slope", [0.05, 0.2, 1.0])
def test_strands_side_by_side_never_change_their_order(segments: int, slope: float) -> None:
    """Parallel strands whose points are out of phase by half a segment, running away from the eye with a slope."""
    rows, pixel = np.linspace(5.0, 255.0, segments + 1), 1.0 / 800.0
    between = np.concatenate([rows[:1], rows[:-1] + 0.5 * np.diff(rows), rows[-1:]])
    for gap in (5e-5, 2e-4, 1e-3):
        front, back = (
            np.column_stack([np.full(len(v), column), v, z + slope * pixel * (v - 5.0)])
            for v, column, z in ((rows, 100.0, 1.0), (between, 100.6, 1.0 + gap))
        )
        for strands, colours in (([front, back], [[1, 0, 0], [0, 1, 0]]), ([back, front], [[0, 1, 0], [1, 0, 0]])):
            film = paint(strands, colours, 2.0, size=200)
            before = film[15:150, 98:103, 0].sum(axis=1)  # between the ends, which are narrow
            assert before == pytest.approx(2.0 / np.interp(np.arange(15.5, 150.0), rows, front[:, 2]), rel=1e-3)


def test_pixels_are_the_fragments_in_order_of_their_depth(lock) -> None:
    """Brute force: every strand alone gives its coverage of all pixels; light is laid over from the back."""
    strands, colours = lock
    film = np.zeros((100, 100, 3))
    for k in np.argsort([-points[0, 2] for points in strands]):
        cover = paint([strands[k]], np.ones((1, 3)), 4.0)[..., :1]
        film += cover * (colours[k] - film)
    assert paint(strands, colours, 4.0) == pytest.approx(film, abs=OPAQUE)


def test_any_order_of_strands_gives_the_same_light(lock) -> None:
    strands, colours = lock
    order = np.random.default_rng(1).permutation(len(strands))
    shuffled = paint([strands[k] for k in order], colours[order], 4.0)
    assert shuffled == pytest.approx(paint(strands, colours, 4.0), abs=OPAQUE)


def test_any_number_of_threads_gives_the_same_bytes(lock, same_on_threads) -> None:
    same_on_threads(lambda: paint(*lock, 0.9))


def test_a_strand_across_tiles_covers_width_times_length_less_its_ends() -> None:
    points = np.column_stack([np.linspace(3.3, 97.1, 12), np.linspace(20.0, 90.0, 12), np.ones(12)])
    length = np.hypot(93.8, 70.0) * (1.0 - TAPER / 3.0) - 0.5 * ROOT * 0.7  # a square root is 2/3 on average
    assert paint([points], np.ones((1, 3)), 0.7)[..., 0].sum() == pytest.approx(0.7 * length, rel=0.01)


def test_hair_fades_below_the_skin() -> None:
    shown = [drawn(line((0.0, 5.5), (10.0, 5.5), 1.0, 2.0 + below), size=10, body=2.0)[5, 5, 0] for below in DEPTHS]
    assert shown == pytest.approx(np.clip(1.0 - DEPTHS / SKIN, 0.0, 1.0), abs=1e-3)


def test_a_strand_is_a_smooth_curve_through_its_points() -> None:
    turn = np.linspace(0.0, np.pi, 7)
    arc = np.stack([50 - 40 * np.cos(turn), 80 - 40 * np.sin(turn), np.ones(7)], axis=1)
    film = paint([arc], np.ones((1, 3)), 1.0)
    rows, columns = np.mgrid[0.5:100, 0.5:100]
    away, cover = np.hypot(columns - 50, rows - 80), film[..., 0] * (rows < 60)
    # along the arc, less its pinned ends, the middle of the line; the chords would lie up to 1.4 pixels inside
    for start in np.radians(np.arange(30, 150, 5)):
        sector = cover * (np.abs(np.arctan2(80 - rows, columns - 50) - start) < np.radians(2.5))
        assert (sector * away).sum() / sector.sum() == pytest.approx(40.0, abs=0.25)


def test_strands_behind_the_eye_are_not_drawn() -> None:
    points = np.array([[10.0, 50, 1], [50, 50, -0.2], [90, 50, -1]])
    assert not paint([points], np.ones((1, 3)), 5.0).any()
