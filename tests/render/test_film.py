"""Light becomes codes as the standards say; what moves while the shutter is open leaves a trace as long as its way."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.render.camera import Camera, Shot
from hairpipe.render.film import MOST, backdrop, develop, instants, linear, outlines, soften
from hairpipe.values import Mesh, Strands

from .conftest import draw_portrait

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


AWAY = np.hypot(*(np.mgrid[0:40, 0:40] - 20))
DISC = AWAY < 10.2


@pytest.mark.parametrize("behind", [np.inf, 1.2])
def test_only_the_outline_of_a_body_is_smoothed_and_light_is_kept(behind: float) -> None:
    """Also where the body stands before itself."""
    depth, film = np.where(DISC, 1.0, behind), np.where(DISC, 1.0, 0.0)[..., None] * np.ones(3)
    smooth, outline = film.copy(), outlines(depth, 100.0)
    soften(smooth, outline, film[outline])
    assert np.array_equal(smooth[np.abs(AWAY - 10.2) > 1.5], film[np.abs(AWAY - 10.2) > 1.5])
    assert smooth.sum() == pytest.approx(film.sum(), rel=0.01)
    assert np.abs(np.diff(smooth[..., 0], axis=0)).max() < 0.8 < np.abs(np.diff(film[..., 0], axis=0)).max()


@pytest.mark.parametrize("focal", [1000.0, 3000.0])
def test_slope_is_not_an_outline(focal: float) -> None:
    """A plane that is turned from the eye by 80 degrees."""
    columns = (np.arange(40) - 20) / focal
    depth = np.broadcast_to(1.0 / (1.0 - np.tan(np.radians(80.0)) * columns), (40, 40))
    assert len(outlines(depth, focal)[0]) == 0


def test_hair_stays_as_it_is_and_an_outline_takes_the_light_of_hair_behind_it() -> None:
    """No line of backdrop between a face and the hair behind it."""
    film = np.where(DISC, 0.5, 1.0)[..., None] * np.ones(3)
    outline = outlines(np.where(DISC, 1.0, np.inf), 100.0)
    before, hair = film[outline], ~DISC
    hair[20] = True  # and a strand in front
    film[hair] = 0.1
    drawn = film.copy()
    soften(film, outline, before)
    assert np.array_equal(film[hair], drawn[hair]) and film.max() == 0.5
    assert (film[DISC & ~hair] < 0.5).sum() > 30


CAMERA = Camera.look_at(np.array([0.0, 1.6, 1.0]), np.array([0.0, 1.6, 0.0]), 40.0, 160, 160)
BROWN = np.array([0.12, 0.06, 0.03])


def moving(hair: Strands, velocity: np.ndarray) -> Strands:
    return replace(hair, velocities=np.broadcast_to(velocity, hair.points.shape).astype(np.float32))


def test_instants_cover_the_time_evenly_and_body_and_hair_move_together(hair: Strands, head: Mesh) -> None:
    velocity = np.array([3.0, -1.0, 0.5])
    flying = replace(head, velocities=np.tile(velocity, (len(head.points), 1)))
    taken = list(instants(moving(hair, velocity), flying, CAMERA, 0.02))
    ways = np.array([(points - hair.points).mean(axis=0) for points, _ in taken]) / velocity
    assert 4 < len(taken) <= MOST
    middles = 0.02 * ((np.arange(len(taken)) + 0.5) / len(taken) - 0.5)
    assert ways == pytest.approx(np.tile(middles[:, None], (1, 3)), abs=0.02 * 0.04 / len(taken))
    for middle, (points, body) in zip(middles, taken, strict=True):
        assert body.points == pytest.approx(head.points + middle * velocity)
        late = (points - hair.points) @ velocity / (velocity @ velocity) - middle
        assert np.abs(late).max() <= 0.5 * 0.02 / len(taken) + 1e-6


def test_hair_at_rest_is_as_sharp_as_with_no_shutter(hair: Strands, head: Mesh) -> None:
    sharp, blurred = (draw_portrait(hair, head, Shot(80, 80), BROWN, 1.0, shutter=shutter) for shutter in (0.0, 0.02))
    assert np.array_equal(sharp, blurred)


def test_a_blurred_picture_is_the_mean_of_many_sharp_ones(hair: Strands) -> None:
    """Hair that moves by a third of the picture; about, for light is added before it is compressed, here after."""
    velocity, shot = np.array([0.0, 4.0, 0.0]), Shot(60, 60, eye=(0.0, 1.6, 1.5), target=(0.0, 1.6, 0.0))
    blurred = draw_portrait(moving(hair, velocity), None, shot, BROWN, 1.0, shutter=0.05).astype(float)
    times = 0.05 * ((np.arange(24) + 0.5) / 24 - 0.5)
    parts = [replace(hair, points=(hair.points + t * velocity).astype(np.float32)) for t in times]
    mean = np.mean([draw_portrait(part, None, shot, BROWN, 1.0).astype(float) for part in parts], axis=0)
    sharp = draw_portrait(hair, None, shot, BROWN, 1.0)
    assert np.abs(blurred - mean).mean() < 0.4 * np.abs(sharp - mean).mean()


def test_velocities_that_are_not_finite_are_refused(hair: Strands, head: Mesh) -> None:
    with pytest.raises(BadInput, match="a velocity is not finite"):
        list(instants(moving(hair, np.array([np.nan, 0.0, 0.0])), head, CAMERA, 0.02))
