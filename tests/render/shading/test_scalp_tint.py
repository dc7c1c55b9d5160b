"""Hair grows where the roots are."""

import numpy as np
import pytest

from hairpipe.render.skin import REACH, hair_share


@pytest.fixture
def roots() -> np.ndarray:
    """An even square of 2,500 roots, 20 cm wide, on the plane y = 1.7."""
    place = np.linspace(-0.1, 0.1, 50)
    x, z = np.meshgrid(place, place)
    return np.stack([x.ravel(), np.full(2500, 1.7), z.ravel()], axis=1)


def test_is_full_among_the_roots_and_nothing_away_from_them(roots: np.ndarray) -> None:
    inside, beside, below = [0.02, 1.7, -0.03], [0.1 + 2 * REACH, 1.7, 0.0], [0.0, 1.7 - 3 * REACH, 0.0]
    share = hair_share(np.array([inside, beside, below]), roots, np.eye(3))
    assert share[0] == pytest.approx(1.0, abs=0.1)
    assert share[1:] == pytest.approx(0.0)


def test_fades_across_the_hairline(roots: np.ndarray) -> None:
    across = np.linspace(0.1 - 2 * REACH, 0.1 + 2 * REACH, 9)
    share = hair_share(np.stack([across, np.full(9, 1.7), np.zeros(9)], axis=1), roots, np.eye(3))
    assert (np.diff(share) <= 0.1).all() and 0.2 < share[4] < 0.8


def test_does_not_depend_on_how_many_roots_there_are(roots: np.ndarray) -> None:
    points = np.stack([np.linspace(-0.12, 0.12, 40), np.full(40, 1.7), np.zeros(40)], axis=1)
    few = hair_share(points, roots[::4], np.eye(3))
    assert few == pytest.approx(hair_share(points, roots, np.eye(3)), abs=0.25)


@pytest.mark.parametrize("count", [60, 120, 1])
def test_few_roots_make_no_spots(roots: np.ndarray, count: int) -> None:
    few = np.random.default_rng(3).permutation(roots)[:count]
    x, z = np.meshgrid(np.linspace(-0.1, 0.1, 80), np.linspace(-0.1, 0.1, 80))
    skin = np.stack([x.ravel(), np.full(6400, 1.7), z.ravel()], axis=1)
    assert hair_share(skin, few, np.eye(3)).max() < 0.5, "spots are as dark as full hair"
