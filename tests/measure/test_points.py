"""Values at the points of hair are those of the laws that each is known by."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.groom.strands import lay_strands
from hairpipe.laws.settings import SagFree
from hairpipe.levelset.bake import bake
from hairpipe.measure.contact import still
from hairpipe.measure.motion import measure_points
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import start
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Strands

HANGING = lay_strands(11, 0.2, 20, (0.0, -1.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)


def hair_of(groom, points):
    return Strands(points, np.zeros(points.shape, np.float32), groom.offsets, 8e-5)


def test_tension_is_the_weight_below_and_stretch_the_change_of_length():
    state = start(build_hair(HANGING, Material(), "network"), None, Scene(sag_free=SagFree()))
    found = measure_points(hair_of(HANGING, 1.02 * HANGING.points), HANGING, state, ())
    assert found.names == ("stretch [%]", "tension [uN]")
    assert found.values[0] == pytest.approx(np.full(len(HANGING.points), 2.0), abs=1e-4)
    weight = 1e6 * Material().line_density * 9.81
    below = 0.2 - 0.01 * (np.array([0, *range(20)]) + 0.5)
    assert found.values[1].reshape(11, 21) == pytest.approx(np.tile(weight * below, (11, 1)), abs=0.03 * weight * 0.2)


def test_depth_is_that_in_a_ball_and_roots_have_none(sphere):
    groom = lay_strands(2, 0.1, 2, (1.0, 0.0, 0.0), (0.0, 0.0, 0.5), None, 0.0)
    balls = still([bake(sphere(0.05, (0.05, 0.0, 0.0)), 0.0025, 8.0)], [])
    found = measure_points(hair_of(groom, groom.points - [0.01, 0.0, 0.0]), None, None, balls)
    assert found.names == ("depth [mm]",)
    assert found.values[0] == pytest.approx([0.0, 40.0, 10.0, 0.0, 0.0, 0.0], abs=0.3)


def test_mismatched_inputs_are_refused():
    other = lay_strands(10, 0.2, 20, (0.0, -1.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    hair = hair_of(HANGING, HANGING.points)
    with pytest.raises(BadInput, match="not the same strands"):
        measure_points(hair, other, None, ())
    with pytest.raises(BadInput, match="no input to measure with"):
        measure_points(hair, None, None, ())
