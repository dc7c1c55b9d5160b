"""Hair at rest, and hair of a mirrored or scaled scene."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.invariance import differences
from hairpipe.graphs.experiments.measure.rest import rest_table
from hairpipe.values import Strands

LINE = np.array([[0.0, 0.0, 0.0], [0.1, 0.02, 0.03]])
LENGTH = float(np.linalg.norm(LINE[1]))


def strands(points, speed=0.0):
    """A strand whose points all have a velocity along X [m/s]."""
    velocities = np.zeros_like(points, np.float32)
    velocities[:, 0] = speed
    return Strands(np.array(points), velocities, np.array([0, 2]), 80e-6)


def test_drift_and_speeds_are_those_of_the_motion():
    moving = {frame: strands(np.add(LINE, [0.001 * frame, 0.0, 0.0]), speed=0.025) for frame in range(1, 50)}
    (row,) = rest_table(moving, strands(LINE), 24.0, 1.0).rows()
    drift, speed, reported, apart, error = row
    assert (drift, speed, reported) == pytest.approx((24.0, 24.0, 25.0), rel=1e-6)
    assert apart == pytest.approx(1.0, rel=1e-5) and error == pytest.approx(4.9 / LENGTH)
    assert np.isnan(next(rest_table(moving, None, 24.0, 1.0).rows())[-1])


@pytest.mark.parametrize("seconds", [0.01, 3.0])
def test_a_duration_that_the_hair_does_not_have_is_refused(seconds):
    moving = {frame: strands(LINE) for frame in range(1, 50)}
    with pytest.raises(BadInput, match="frames of 49"):
        rest_table(moving, None, 24.0, seconds)


def test_a_mirrored_and_scaled_scene_is_the_same():
    truth = {frame: strands(LINE * frame) for frame in range(1, 10)}
    large = {frame: strands(4.0 * LINE * (1.0 + 0.5 * (frame - 1)) * [1.0, 1.0, -1.0]) for frame in range(1, 10)}
    found = differences(large, truth, 24.0, "z", 4.0, 2)
    assert len(found) == 5 and found.numbers["difference [% of length]"].max() < 1e-12
    assert differences(large, truth, 24.0, None, 4.0, 2).numbers["difference [% of length]"].min() > 10.0


def test_other_strands_are_refused():
    three = Strands(np.zeros((3, 3)), np.zeros((3, 3), np.float32), np.array([0, 3]), 80e-6)
    with pytest.raises(BadInput, match="3 and 2 points"):
        differences({1: three}, {1: strands(LINE)}, 24.0, None, 1.0, 1)
