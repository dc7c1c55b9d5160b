"""The frame holds still while hair moves, and the camera stands where the frame fills the film."""

import numpy as np
import pytest

from hairpipe.render.camera import Framing, Shot, frame_hair, place_camera, radius_of
from hairpipe.values import Strands


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
