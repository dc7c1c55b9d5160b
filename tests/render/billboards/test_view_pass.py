"""Billboards cover what theory says."""

import numpy as np
import pytest

from hairpipe.render.cloud import FADE, SUNK, Sprites, paint

FAR = np.full((64, 64), np.inf)


def painted(sprites: Sprites, levels, colours: np.ndarray | None = None, depth: np.ndarray = FAR) -> np.ndarray:
    """Paint white, or these colours, over black."""
    film = np.zeros((64, 64, 3), np.float32)
    paint(film, depth, sprites, np.ones((len(sprites.places), 3)) if colours is None else colours, levels)
    return film


@pytest.mark.parametrize("turn", [0.0, 0.5, np.pi / 2, 2.2])
def test_a_billboard_that_faces_the_eye_covers_its_area_times_its_opacity(turn, boards, plain) -> None:
    film = painted(boards([1.0], 0.4, turn=turn), plain)
    assert film.sum() / 3 == pytest.approx(0.4 * 20 * 10, rel=0.03)
    assert np.unique(film) == pytest.approx([0.0, 0.4])


@pytest.mark.parametrize("lean", [30.0, 60.0, 75.0])
def test_hair_that_leans_away_is_shorter_and_denser(lean, boards, plain) -> None:
    """As much hair is seen by fewer rays; nearer to the ray than asin 0.15 that ends."""
    facing, leaning = (painted(boards([1.0], 0.2, angle), plain) for angle in (0.0, lean))
    assert leaning.sum() == pytest.approx(facing.sum(), rel=0.06)
    assert leaning.max() == pytest.approx(0.2 / np.cos(np.radians(lean)), rel=1e-5)
    assert painted(boards([1.0], 0.01, 89.0), plain).max() == pytest.approx(0.01 / 0.15, rel=1e-5)


def test_the_nearer_lies_over_the_farther_in_whatever_order_they_come(boards, plain) -> None:
    sprites, colours = boards([3.0, 1.0, 2.0], 0.4), np.eye(3)
    film = painted(sprites, plain, colours)
    assert film[32, 32] == pytest.approx([0.4 * 0.6**2, 0.4, 0.4 * 0.6])
    for order in ([1, 2, 0], [2, 1, 0]):
        other = Sprites(*(field[order] for field in sprites))
        assert np.array_equal(painted(other, plain, colours[order]), film)


def test_a_body_hides_what_is_behind_it_softly(boards, plain) -> None:
    sprites = boards([1.0], 0.4)
    for ahead, share in ((0.1, 1.0), (FADE - SUNK, 1.0), (0.5 * FADE - SUNK, 0.5), (-SUNK - 1e-6, 0.0)):
        film = painted(sprites, plain, depth=np.full((64, 64), 1.0 + ahead))
        assert film[32, 32] == pytest.approx(0.4 * share, abs=1e-5)


def test_nothing_is_drawn_behind_the_eye_or_outside_of_the_film(boards, plain) -> None:
    assert painted(boards([-1.0, 0.0], 0.4), plain).max() == 0.0
    sprites = boards([1.0], 0.4)
    assert painted(sprites._replace(places=sprites.places + np.array((1e6, -1e6, 0.0))), plain).max() == 0.0
