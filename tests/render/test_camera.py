"""The pinhole against its closed form, the frame that holds still while hair moves, and the lamps around the camera."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.render.camera import NEAR, Camera, Framing, Shot, frame_hair, place_camera, radius_of
from hairpipe.render.lights import studio
from hairpipe.values import Strands


def test_projects_as_a_pinhole() -> None:
    camera = Camera.look_at([0.0, 1.0, 2.0], [0.0, 1.0, 0.0], 90.0, 200, 100)
    seen = camera.project(np.array([[0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.5, 1.0], [0.0, 3.0, 0.0]]))
    # 90 degrees across the 100 rows: a focal length of 50 pixels
    assert seen == pytest.approx(np.array([[100, 50, 2], [125, 50, 2], [100, 25, 1], [100, 0, 2]]), abs=1e-9)


def test_axes_are_a_rotation_with_up_upwards() -> None:
    rng = np.random.default_rng(0)
    for eye, target in rng.normal(size=(50, 2, 3)):
        axes = Camera.look_at(eye, target, 30.0, 64, 64).axes
        assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-12)
        assert axes[1, 1] > 0 and axes[0, 1] == pytest.approx(0)
        assert np.cross(axes[0], axes[1]) == pytest.approx(-axes[2])


def test_looks_straight_down() -> None:
    camera = Camera.look_at([0.0, 2.0, 0.0], [0.0, 0.0, 0.0], 30.0, 64, 64)
    assert camera.project(np.zeros((1, 3)))[0] == pytest.approx([32, 32, 2])


def test_points_behind_the_eye_are_finite() -> None:
    seen = Camera.look_at([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 30.0, 64, 64).project(np.array([[0.0, 0, 1], [1, 1, 5]]))
    assert np.isfinite(seen).all()
    assert (seen[:, 2] < NEAR).all()


def test_enlarging_scales_the_film_only() -> None:
    camera = Camera.look_at([0.3, 1.0, 2.0], [0.0, 1.0, 0.0], 40.0, 60, 40)
    points = np.random.default_rng(1).normal(size=(20, 3)) * 0.3
    assert camera.enlarged(3).project(points) == pytest.approx(camera.project(points) * [3, 3, 1])


def test_refuses_an_eye_at_its_target() -> None:
    with pytest.raises(BadInput, match="eye, target: the eye is at the target"):
        Camera.look_at([1.0, 1.0, 1.0], [1.0, 1.0, 1.0], 30.0, 64, 64)


def test_hair_that_swings_moves_neither_centre_nor_scale(hair: Strands) -> None:
    points = hair.points.astype(float)
    roots = np.repeat(points[hair.offsets[:-1]], np.diff(hair.offsets), axis=0)
    swung = roots + (points - roots) @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    still, moved = frame_hair(points, hair.offsets), frame_hair(swung, hair.offsets)
    assert moved.target == pytest.approx(still.target)
    assert moved.radius == pytest.approx(still.radius)


def test_a_head_that_walks_and_turns_keeps_its_scale(hair: Strands) -> None:
    points = hair.points.astype(float)
    turned = points @ np.array([[0.6, 0, -0.8], [0, 1, 0], [0.8, 0, 0.6]]).T + [5.0, 0.3, -2.0]
    assert frame_hair(turned, hair.offsets).radius == pytest.approx(frame_hair(points, hair.offsets).radius)


def test_a_given_radius_takes_the_place_of_that_of_the_hair(hair: Strands) -> None:
    points = hair.points.astype(float)
    own, wide = frame_hair(points, hair.offsets), frame_hair(points, hair.offsets, 0.7)
    assert wide.radius == 0.7 and own.radius == radius_of(points, hair.offsets) != 0.7
    assert wide.target[[0, 2]] == pytest.approx(own.target[[0, 2]])


@pytest.mark.parametrize("size", [(300, 300), (400, 200), (200, 400)])
def test_the_radius_reaches_from_the_middle_to_the_nearer_edge(size: tuple[int, int]) -> None:
    framing = Framing(np.array([0.2, 1.5, -0.1]), 0.3)
    camera = place_camera(Shot(*size, grain=1), framing)
    edge = framing.target + framing.radius * camera.axes[:2]
    expected = [[size[0] / 2 + min(size) / 2, size[1] / 2], [size[0] / 2, size[1] / 2 - min(size) / 2]]
    assert camera.project(edge)[:, :2] == pytest.approx(np.array(expected))


def test_views_stand_around_the_head() -> None:
    framing = Framing(np.zeros(3), 0.3)
    ahead = {view: place_camera(Shot(64, 64, view), framing).axes[2] for view in ("front", "side", "back")}
    assert ahead["front"][2] < -0.9 and ahead["back"][2] > 0.9 and ahead["side"][0] < -0.9


def test_eye_and_target_are_taken_as_given() -> None:
    shot = Shot(64, 64, eye=(1.0, 2.0, 3.0), target=(0.5, 2.0, 3.0))
    camera = place_camera(shot, Framing(np.zeros(3), 0.3))
    assert camera.eye == pytest.approx([1, 2, 3])
    assert camera.axes[2] == pytest.approx([-1, 0, 0])


def test_a_target_alone_keeps_the_distance() -> None:
    framing = Framing(np.zeros(3), 0.3)
    moved = place_camera(Shot(64, 64, target=(1.0, 0.0, 0.0)), framing)
    assert moved.eye - [1, 0, 0] == pytest.approx(place_camera(Shot(64, 64), framing).eye)


def test_the_eye_goes_around_the_target_on_a_circle() -> None:
    framing = Framing(np.array([0.1, 0.0, 0.0]), 0.3)
    turned, side = place_camera(Shot(64, 64, "front", turn=90.0), framing), place_camera(Shot(64, 64, "side"), framing)
    assert turned.eye == pytest.approx(side.eye) and turned.axes == pytest.approx(side.axes)
    given = Shot(64, 64, eye=(1.0, 0.5, 0.0), target=(0.0, 0.0, 0.0), turn=-90.0)
    assert place_camera(given, framing).eye == pytest.approx([0.0, 0.5, 1.0])


def test_lamps_turn_with_the_camera() -> None:
    front = studio(Camera.look_at([0.0, 0, 1], [0.0, 0, 0], 30.0, 8, 8).axes)
    side = studio(Camera.look_at([1.0, 0, 0], [0.0, 0, 0], 30.0, 8, 8).axes)
    turn = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    for one, other in zip(front, side, strict=True):
        assert other.towards == pytest.approx(turn @ one.towards)
        assert np.linalg.norm(one.towards) == pytest.approx(1.0)


def test_the_key_is_in_front_from_the_upper_left_and_a_rim_behind() -> None:
    lamps = studio(Camera.look_at([0.0, 0, 1], [0.0, 0, 0], 30.0, 8, 8).axes)
    brightest = max(lamps, key=lambda lamp: lamp.colour.sum())
    assert brightest.towards[0] < 0 and brightest.towards[1] > 0 and brightest.towards[2] > 0
    assert min(lamp.towards[2] for lamp in lamps) < -0.3
