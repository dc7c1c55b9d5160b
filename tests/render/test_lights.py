"""The lamps hang around the camera."""

import numpy as np
import pytest

from hairpipe.render.camera import Camera
from hairpipe.render.lights import studio


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
