"""The radius of a helix is the radius of the helix."""

import numpy as np
import pytest

from hairpipe.engine import Frames, Time
from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, turn_of
from hairpipe.graphs.experiments.measure.curls import radius
from hairpipe.graphs.experiments.nodes.measure_curls import measure_curls
from hairpipe.groom.strands import lay_strands
from hairpipe.values import Strands


def curls(width, pitch=0.02, segments=80):
    return lay_strands(1, 0.25, segments, (1.0, 2.0, 0.3), (0.0, 0.0, 0.01), Helix(width, pitch), 0.0).points


@pytest.mark.parametrize("width", [0.003, 0.006, 0.012])
def test_a_helix_has_its_own_radius(width):
    points = curls(width)
    turn = turn_of(points)
    assert turn * 0.25 / 80 == pytest.approx(np.hypot(2 * np.pi * width, 0.02), rel=0.06)
    assert radius(points, turn) == pytest.approx(width, rel=0.02)


def test_a_bent_helix_keeps_its_radius():
    points = curls(0.004, segments=200)
    axis = np.array([1.0, 2.0, 0.3]) / np.linalg.norm([1.0, 2.0, 0.3])
    height = points @ axis
    bent = points + np.outer(4.0 * height**2, [0.0, 0.0, 1.0])
    assert radius(bent, turn_of(points)) == pytest.approx(radius(points, turn_of(points)), rel=0.03)


def test_it_is_followed_over_time_and_straight_strands_do_not_count():
    straight = np.linspace([0, 0, 0], [0, 0.2, 0], 81)
    offsets = np.array([0, 81, 162], np.int32)

    def hair(scale):
        middle = curls(0.006).mean(axis=0)
        axis = np.array([1.0, 2.0, 0.3]) / np.linalg.norm([1.0, 2.0, 0.3])
        along = np.outer((curls(0.006) - middle) @ axis, axis) + middle
        points = np.concatenate([straight, along + scale * (curls(0.006) - along)]).astype(np.float32)
        return Strands(points, points * 0, offsets, 8e-5)

    values = {1: hair(1.0), 2: hair(0.5), 4: hair(1.0)}
    table = measure_curls(Frames((1, 2, 4), values.__getitem__), Time(1, 10.0))
    assert table["time [s]"] == pytest.approx([0.0, 0.1, 0.3])
    assert table["of the first [%]"] == pytest.approx([100.0, 50.0, 100.0], abs=0.5)
    assert table["curl radius [mm]"] == pytest.approx([6.0, 3.0, 6.0], rel=0.03)
    np.testing.assert_array_equal(table["smallest [mm]"], table["curl radius [mm]"])


def test_hair_without_curls_is_refused():
    points = np.linspace([0, 0, 0], [0, 0.2, 0], 81).astype(np.float32)
    values = {1: Strands(points, points * 0, np.array([0, 81], np.int32), 8e-5)}
    with pytest.raises(BadInput, match="whole turn"):
        measure_curls(Frames((1,), values.__getitem__), Time(1, 10.0))
