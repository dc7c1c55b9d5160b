"""Where hair shines, and that its variation hangs on nothing but the index."""

import numpy as np
import pytest

from hairpipe.render.kajiya_kay import MATT, Fibres, add_light, lie, noise, strand_colours
from hairpipe.render.lights import Light


def shine(along: np.ndarray, to_eye: np.ndarray, towards: np.ndarray, tilt: float = 0.0) -> float:
    """What one black hair, which has the white highlight only, sends to a far eye."""
    shed = np.zeros((1, 3))
    hair = Fibres(np.zeros((1, 3)), along[None], np.zeros((1, 3)), np.zeros((1, 3)), np.sin([tilt]))
    add_light(shed, hair, 1e6 * to_eye, Light(towards, np.ones(3)), np.zeros(1))
    return float(shed[0, 0])


def turned(angle: float) -> np.ndarray:
    """Unit vector at an angle from x towards y [degrees]."""
    return np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0])


@pytest.mark.parametrize("lamp", [40.0, 75.0, 90.0, 120.0])
def test_the_highlight_is_the_mirror_image_of_the_lamp(lamp: float) -> None:
    eyes = np.arange(5.0, 176.0)
    seen = [shine(np.array([1.0, 0, 0]), turned(eye), turned(lamp)) for eye in eyes]
    assert eyes[np.argmax(seen)] == pytest.approx(180.0 - lamp)


def test_tilted_scales_move_the_highlight_to_the_root_by_twice_the_tilt() -> None:
    # The tip is along x: scales face the root, and their normal is at 95 degrees.
    eyes = np.arange(5.0, 176.0)
    seen = [shine(np.array([1.0, 0, 0]), turned(eye), turned(70.0), np.radians(5.0)) for eye in eyes]
    assert eyes[np.argmax(seen)] == pytest.approx(2.0 * 95.0 - 70.0)


def test_root_to_tip_or_tip_to_root_shines_alike_without_tilt() -> None:
    there, back = shine(turned(20.0), turned(95.0), turned(130.0)), shine(-turned(20.0), turned(95.0), turned(130.0))
    assert there == pytest.approx(back) and there > 0


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_diffuse_light_by_normals_is_lamberts_and_the_rest_kajiyas(share: float) -> None:
    """White hair along z, whose tilt turns its highlights away: only the diffuse light depends on the normal."""
    lamps = 0.0, 60.0, 120.0

    def diffuse(facing: np.ndarray, lamp: float) -> float:
        shed, white = np.zeros((1, 3)), np.ones((1, 3))
        hair = Fibres(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), facing[None], white, np.zeros(1))
        add_light(shed, hair, 1e6 * turned(lamp), Light(turned(lamp), np.ones(3)), np.zeros(1))
        return shed[0, 0]

    without = [diffuse(np.zeros(3), lamp) for lamp in lamps]
    found = [diffuse(share * turned(0.0), lamp) for lamp in lamps]
    lambert = np.maximum(0.0, np.cos(np.radians(lamps)))
    assert np.array(found) - without == pytest.approx(MATT * share * (lambert - 1.0))  # sin(t,l) is 1


def test_noise_is_even_between_its_ends_and_differs_between_seeds() -> None:
    one, two = noise(20_000, 1), noise(20_000, 2)
    assert abs(one.mean()) < 0.02 and one.var() == pytest.approx(1 / 3, rel=0.03)
    assert one.min() >= -1 and one.max() <= 1
    assert abs(np.corrcoef(one, two)[0, 1]) < 0.03 and abs(np.corrcoef(one[1:], one[:-1])[0, 1]) < 0.03


def test_a_strand_keeps_its_colour_when_others_follow() -> None:
    colour, sites = np.array([0.2, 0.1, 0.05]), np.arange(15)
    few, many = (strand_colours(colour, np.arange(0, end, 4), sites // 8, sites) for end in (9, 13))
    assert np.array_equal(few, many) and (np.diff(few[:7], axis=0) > 0).all()


def test_sites_lie_on_a_circle_through_its_points_and_in_their_middles() -> None:
    turn = np.linspace(0, 1, 30)
    circle, sites = np.stack([np.cos(turn), np.sin(turn), np.zeros(30)], axis=1), np.arange(2, 57)
    at = np.interp(0.5 * sites, np.arange(30), turn)
    exact = np.stack([np.cos(at), np.sin(at), np.zeros(55)], axis=1)
    ahead = np.stack([-np.sin(at), np.cos(at), np.zeros(55)], axis=1)
    both = np.concatenate([circle, circle[::-1]])
    for strand, way in ((0, 1), (1, -1)):
        places, along = lie(both, np.array([0, 30, 60]), np.full(55, strand, np.int32), 60 * strand + sites)
        assert places == pytest.approx(exact[::way], abs=1e-6)  # fourth order
        assert along == pytest.approx(way * ahead[::way], abs=1e-6)
