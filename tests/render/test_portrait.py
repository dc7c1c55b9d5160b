"""Laws of whole pictures, of hair and of a mesh on its floor."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.render import shadows
from hairpipe.render.camera import Framing, Shot, radius_of
from hairpipe.render.dual_scattering import shade_dual
from hairpipe.render.portrait import draw_object
from hairpipe.values import Mesh, Strands

from .conftest import draw_portrait

BROWN = np.array([0.12, 0.06, 0.03])


def take(hair: Strands, body: Mesh | None, shot: Shot, thickness: float = 1.0) -> np.ndarray:
    """Take a picture in brown."""
    return draw_portrait(hair, body, shot, BROWN, thickness)


def test_scene_and_camera_turned_together_give_the_same_picture(hair: Strands, head: Mesh) -> None:
    turn = np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]])
    eye, target = np.array([0.5, 1.7, 1.1]), np.array([0.0, 1.55, 0.0])
    still = take(hair, head, Shot(160, 160, eye=tuple(eye), target=tuple(target)))
    turned_hair = replace(hair, points=(hair.points @ turn.T).astype(np.float32))
    turned_head = Mesh(head.points @ turn.T, head.triangles)
    turned = take(turned_hair, turned_head, Shot(160, 160, eye=tuple(turn @ eye), target=tuple(turn @ target)))
    off = np.abs(still.astype(int) - turned)
    assert off.mean() < 0.1 and np.mean(off > 8) < 0.002


def test_twice_the_radius_halves_the_hair_in_the_picture(hair: Strands) -> None:
    own = radius_of(hair.points.astype(float), hair.offsets)
    rows = []
    for shot in (Shot(160, 160, radius=2.0 * own), Shot(160, 160, radius=4.0 * own)):
        picture = take(hair, None, shot).astype(int)
        covered = picture[..., 0] - picture[..., 2] > 24  # brown on grey
        rows.append(np.ptp(np.flatnonzero(covered.any(axis=0))))
    assert (take(hair, None, Shot(160, 160)) == take(hair, None, Shot(160, 160, radius=own))).all()
    assert rows[1] == pytest.approx(0.5 * rows[0], abs=4)


def test_the_camera_follows_a_head_that_walks(hair: Strands, head: Mesh) -> None:
    step = np.array([2.0, 0.0, -1.0])
    there = replace(hair, points=(hair.points + step).astype(np.float32)), Mesh(head.points + step, head.triangles)
    off = np.abs(take(hair, head, Shot(160, 160)).astype(int) - take(*there, Shot(160, 160)))
    assert off.mean() < 0.1


def test_pictures_do_not_depend_on_parallel_work(hair: Strands, head: Mesh) -> None:
    shots = [Shot(120, 90, view) for view in ("front", "back", "side", "three_quarter")]
    alone = [take(hair, head, shot) for shot in shots]
    with ThreadPoolExecutor(4) as pool:
        beside = list(pool.map(lambda shot: take(hair, head, shot), shots))
    assert all(np.array_equal(a, b) for a, b in zip(alone, beside, strict=True))


def test_fewer_cells_of_faint_lamps_change_a_picture_no_more_than_cells_elsewhere(hair, head, monkeypatch) -> None:
    few, pictures = shadows.FEW, []
    for count in (shadows.CELLS, shadows.CELLS + 1, few):
        monkeypatch.setattr(shadows, "FEW", count)
        pictures.append(take(hair, head, Shot(160, 160)).astype(int))
    all_cells, elsewhere, fewer = pictures
    assert few < shadows.CELLS and np.any(fewer != all_cells)
    assert np.abs(fewer - all_cells).mean() < 2.0 * np.abs(elsewhere - all_cells).mean()


def test_hair_of_dual_scattering_is_equal_on_any_number_of_threads(hair: Strands, head: Mesh, same_on_threads) -> None:
    picture = same_on_threads(lambda: draw_portrait(hair, head, Shot(90, 90), BROWN, 1.0, shade_dual))
    assert (picture != take(hair, head, Shot(90, 90))).any()


def test_the_picture_has_the_size_requested(hair: Strands) -> None:
    picture = take(hair, None, Shot(90, 50))
    assert picture.shape == (50, 90, 3) and picture.dtype == np.uint8


def test_the_body_is_in_the_picture(hair: Strands, head: Mesh) -> None:
    assert np.mean(take(hair, head, Shot(100, 100)) != take(hair, None, Shot(100, 100))) > 0.05


def test_few_strands_are_drawn_thick_enough_to_be_seen(hair: Strands) -> None:
    one = Strands(hair.points[:16], hair.velocities[:16], hair.offsets[:2], 80e-6)
    invisible = take(one, None, Shot(200, 200), thickness=1e-6)
    assert np.abs(take(one, None, Shot(200, 200)).astype(int) - invisible).max() > 50


def test_an_explosion_is_drawn_and_ends(hair: Strands, head: Mesh) -> None:
    points = hair.points.copy()
    points[40:60] *= np.float32(1e30)
    points[100:104] = [0.0, 3e38, -3e38]
    assert take(replace(hair, points=points), head, Shot(100, 100)).shape == (100, 100, 3)


def test_points_that_are_not_finite_are_refused_by_strand(hair: Strands) -> None:
    points = hair.points.copy()
    points[16 * 3 + 5, 1], points[16 * 250, 0] = np.nan, np.inf
    with pytest.raises(BadInput, match=r"2 strands have points that are not finite: 3, 250"):
        take(replace(hair, points=points), None, Shot(64, 64))


def test_a_body_that_is_not_finite_is_refused(hair: Strands, head: Mesh) -> None:
    points = head.points.copy()
    points[77, 2] = np.nan
    with pytest.raises(BadInput, match="vertex 77 is not finite"):
        take(hair, Mesh(points, head.triangles), Shot(64, 64))


def test_no_strands_are_refused(hair: Strands) -> None:
    with pytest.raises(BadInput, match="no strands"):
        take(Strands(hair.points[:0], hair.velocities[:0], np.zeros(1, np.int32), 80e-6), None, Shot(64, 64))


def test_deep_shadows_and_those_of_the_cube_give_the_same_light_but_for_their_edges(hair: Strands, head: Mesh) -> None:
    shot = Shot(120, 120)
    cube, deep = (draw_portrait(hair, head, shot, BROWN, 1.0, shadow=name).astype(int) for name in ("cube", "deep"))
    off = np.abs(deep - cube)
    assert off.max() > 8 and off.mean() < 2.0 and abs(deep.mean() - cube.mean()) < 1.0


SHOT = Shot(64, 48, eye=(0.0, 1.5, 4.0), target=(0.0, 0.4, 0.0), fov=30.0)
FRAMING = Framing(np.array([0.0, 0.4, 0.0]), 1.0)
RED = np.array([0.6, 0.02, 0.02])


def is_red(picture):
    red, green, blue = (picture[:, :, c].astype(int) for c in range(3))
    return (red > green + 40) & (red > blue + 40)


def test_the_mesh_is_where_it_should_be(sphere):
    red = is_red(draw_object(sphere(0.4, (0.0, 0.4, 0.0), 3), SHOT, FRAMING, RED))
    rows, columns = np.nonzero(red)
    assert abs(rows.mean() - 23.5) < 1 and abs(columns.mean() - 31.5) < 1
    radius = 24 / np.tan(np.radians(15)) * np.tan(np.arcsin(0.4 / np.hypot(4.0, 1.1)))
    assert red.sum() == pytest.approx(np.pi * radius**2, rel=0.1)


def test_the_floor_hides_what_is_under_it(sphere):
    assert not is_red(draw_object(sphere(0.4, (0.0, -0.6, 0.0), 3), SHOT, FRAMING, RED)).any()


def test_the_mesh_casts_a_shadow_on_the_floor(sphere):
    nothing = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    without = draw_object(nothing, SHOT, FRAMING, RED).astype(int)
    ball = draw_object(sphere(0.3, (0.0, 0.3, 0.0), 3), SHOT, FRAMING, RED)
    darker = (without - ball.astype(int)).mean(axis=2) > 15
    assert (darker & ~is_red(ball)).sum() > 20


def test_non_finite_positions_are_refused(sphere):
    ball = sphere(0.3, level=1)
    ball.points[3] = np.nan
    with pytest.raises(BadInput, match="not finite"):
        draw_object(ball, SHOT, FRAMING, RED)
