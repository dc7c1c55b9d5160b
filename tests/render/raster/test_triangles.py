"""Triangles against outlines known in closed form and against brute force."""

import numpy as np
import pytest

from hairpipe.render.surface import UNSEEN, first_centre, rasterise


def test_a_pixel_sees_a_triangle_when_its_centre_lies_in_it() -> None:
    rng = np.random.default_rng(5)
    for film in rng.uniform(-5, 25, size=(40, 3, 2)):
        seen, _ = rasterise(film, np.array([[0, 1, 2]], np.int32), np.ones(3), 20, 20)
        rows, columns = np.mgrid[0.5:20, 0.5:20]
        centres = np.stack([columns, rows], axis=2)
        sides = [np.cross(film[k - 2] - film[k], centres - film[k]) for k in range(3)]
        inside = (np.min(sides, axis=0) >= 0) | (np.max(sides, axis=0) <= 0)
        assert np.array_equal(seen != UNSEEN, inside)


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_the_closer_triangle_is_seen_in_any_order(order: list[int]) -> None:
    film = np.array([[-9.0, -9], [40, -9], [-9, 40]] * 2)
    closeness = np.array([1.0, 1, 1, 2, 2, 2])
    triangles = np.array([[0, 1, 2], [3, 4, 5]], np.int32)[order]
    seen, close = rasterise(film, triangles, closeness, 8, 8)
    assert (triangles[seen] == [3, 4, 5]).all()
    assert close == pytest.approx(2.0)


def test_triangles_behind_the_eye_are_omitted() -> None:
    film = np.array([[-9.0, -9], [40, -9], [-9, 40]])
    seen, _ = rasterise(film, np.array([[0, 1, 2]], np.int32), np.array([1.0, 0.0, 1.0]), 8, 8)
    assert (seen == UNSEEN).all()


@pytest.mark.parametrize("x", [-1e300, -0.1, 0.0, 0.5, 0.51, 3.5, 7.49, 7.51, 1e300])
def test_first_centre_is_the_first_that_is_not_before(x: float) -> None:
    assert first_centre(x, 8) == sum(centre < x for centre in np.arange(8) + 0.5)
