"""Light becomes codes as the standards say."""

import numpy as np
import pytest

from hairpipe.render.film import backdrop, develop, linear, soften

GRAIN = 2


def test_srgb_against_the_standard() -> None:
    # IEC 61966-2-1: the foot is straight with slope 1/12.92; the middle grey code 188 is half the light
    assert linear((0.0, 0.04, 1.0)) == pytest.approx([0.0, 0.04 / 12.92, 1.0])
    assert linear((188 / 255,) * 3) == pytest.approx(0.5, abs=0.005)


def test_more_light_is_brighter_and_never_wraps() -> None:
    lights = [np.full((4, 4, 3), x, np.float32) for x in (0, 0.01, 0.1, 1, 10, 1e6)]
    codes = [int(develop(light, GRAIN)[1, 1, 0]) for light in lights]
    assert codes == sorted(codes) and codes[0] == 0 and codes[-1] == 255


def test_a_pixel_is_the_mean_of_its_part_of_the_film() -> None:
    film = np.zeros((8 * GRAIN, 8 * GRAIN, 3), np.float32)
    film[3 * GRAIN : 4 * GRAIN, 5 * GRAIN : 6 * GRAIN, 1] = 0.5
    lit = develop(film, GRAIN) > 0
    assert lit[3, 5].tolist() == [False, True, False] and lit.sum() == 1


def test_backdrop_is_brightest_near_the_middle_and_even_to_both_sides() -> None:
    wall = backdrop(60, 80)
    row, column, _ = np.unravel_index(wall.argmax(), wall.shape)
    assert abs(row - 30) < 5 and abs(column - 40) <= 1
    assert wall == pytest.approx(wall[:, ::-1])


def test_only_the_outline_of_a_body_is_smoothed_and_light_is_kept() -> None:
    rows, columns = np.mgrid[0:40, 0:40]
    away = np.hypot(rows - 20, columns - 20)
    depth, film = np.where(away < 10.2, 1.0, np.inf), np.where(away < 10.2, 1.0, 0.0)[..., None] * np.ones(3)
    smooth = film.copy()
    soften(smooth, depth)
    assert np.array_equal(smooth[np.abs(away - 10.2) > 1.5], film[np.abs(away - 10.2) > 1.5])
    assert smooth.sum() == pytest.approx(film.sum(), rel=0.01)
    assert np.abs(np.diff(smooth[..., 0], axis=0)).max() < 0.8 < np.abs(np.diff(film[..., 0], axis=0)).max()
