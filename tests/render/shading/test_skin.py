"""Hair grows where the roots are, and the skin has its tint there."""

import numpy as np
import pytest

from hairpipe.render.lights import Light
from hairpipe.render.shadows import CELLS, Shadow
from hairpipe.render.skin import AMBIENT, DENSITY, PENUMBRA, REACH, SAMPLES, hair_share, shade_skin, soft_depth
from hairpipe.render.surface import Surface

EYE = np.array([0.0, 0.0, 5.0])
TO_CELLS = np.column_stack([np.eye(3), np.full(3, CELLS / 2)])


def shade(normals: np.ndarray, depth: float = 0.0, brightness: float = 1.0) -> np.ndarray:
    """White skin at the origin with these normals, under a lamp at +X behind hair of this depth."""
    count = len(normals)
    none, film = np.zeros(count, int), np.zeros((1, 1))
    cells = np.full((CELLS, CELLS, CELLS), depth, np.float32)
    shadow = Shadow(Light(np.array([1.0, 0.0, 0.0]), np.full(3, brightness)), TO_CELLS, 1.0, cells)
    surface = Surface(none, none, np.zeros((count, 3)), normals, film)
    return shade_skin(surface, np.ones((count, 3)), EYE, [shadow])


def around(angles: np.ndarray) -> np.ndarray:
    """Normals at these angles from the lamp, in the plane the eye looks along [degrees]."""
    turn = np.radians(angles)
    return np.stack([np.cos(turn), -np.sin(turn), np.zeros_like(turn)], axis=1)


def test_grows_darker_the_farther_it_turns_from_the_lamp() -> None:
    light = shade(around(np.arange(0.0, 181.0, 10.0)))
    assert (np.diff(light, axis=0) <= 1e-12).all()
    assert light[-1] == pytest.approx(AMBIENT)


def test_the_edge_of_the_light_is_warm() -> None:
    red, green, blue = shade(around(np.array([95.0])))[0]
    assert red > green > blue


def test_hair_before_the_lamp_takes_its_light() -> None:
    facing = around(np.array([20.0]))
    bare, thin, thick = (shade(facing, depth)[0, 1] for depth in (0.0, 2.0, 200.0))
    assert bare > thin > thick and thick == pytest.approx(AMBIENT)
    # each layer takes the same share
    assert (shade(facing, 4.0)[0, 1] - AMBIENT) * (bare - AMBIENT) == pytest.approx((thin - AMBIENT) ** 2)


def test_twice_the_light_is_twice_as_bright() -> None:
    facing = around(np.array([30.0, 80.0]))
    assert shade(facing, 1.0, 2.0) - AMBIENT == pytest.approx(2 * (shade(facing, 1.0, 1.0) - AMBIENT))


class HalfPlane:
    """The shadow of an opaque half plane: y < 0 is dark."""

    cell = PENUMBRA

    def __init__(self, brightness):
        self.light = Light(np.array([1.0, 0.0, 0.0]), np.full(3, brightness))

    def between(self, points):
        return np.where(points[:, 1] < 0.0, 1e3, 0.0)


def test_the_edge_of_a_shadow_is_as_wide_as_the_disc():
    y = np.linspace(-2.0, 2.0, 41) * PENUMBRA
    points = np.stack([np.zeros(41), y, np.zeros(41)], axis=1)
    through = np.exp(-DENSITY * soft_depth(HalfPlane(2.0), points))
    assert (np.diff(through) >= 0.0).all() and len(np.unique(through)) > 6
    np.testing.assert_allclose(through[[0, 9, -10, -1]], [0.0, 0.0, 1.0, 1.0], atol=1e-12)
    x = y / PENUMBRA
    inside = np.abs(x) < 1.0
    area = 0.5 + (x * np.sqrt(1.0 - x * x, where=inside) + np.arcsin(x, where=inside)) / np.pi
    assert np.abs(through - area)[inside].max() < 1.5 / SAMPLES
    sharp = soft_depth(HalfPlane(0.5), points)
    assert np.array_equal(sharp, HalfPlane(0.5).between(points))


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
