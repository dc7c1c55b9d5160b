"""A mesh on its floor, as the camera sees it."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.render.camera import Framing, Shot
from hairpipe.render.portrait import draw_object
from hairpipe.values import Mesh

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
