"""The pinhole against its closed form."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.render.camera import NEAR, Camera


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
