"""Errors of a simulation, and where it failed."""

import numpy as np
import pytest

from hairpipe.engine import Frames, Reached
from hairpipe.errors import BadInput
from hairpipe.groom.strands import lay_strands
from hairpipe.levelset.bake import bake
from hairpipe.nodes.measure_fidelity import measure_fidelity
from hairpipe.values import Strands

DOWN = (0.0, -1.0, 0.0)
G, L = 10.0, 0.2


def hanging(segments=4, shift=0.0, speed=0.0, stretch=0.0):
    """A strand of 20 cm that hangs, moved to the side, moving, and longer at its last segment."""
    points = lay_strands(1, L, segments, DOWN, (0.01, 0.0, 0.0), None, 0.0).points
    points[:, 0] += shift
    points[-1, 1] -= stretch * L / segments
    velocities = np.tile(np.array([speed, 0.0, 0.0], np.float32), (len(points), 1))
    return Strands(points.astype(np.float32), velocities, np.array([0, segments + 1], np.int32), 8e-5)


def frames(kind, *values):
    return kind(tuple(range(1, len(values) + 1)), dict(enumerate(values, 1)).__getitem__)


def measured(hair, **settings):
    truth = frames(Frames, *[hanging(8)] * 4)
    return measure_fidelity(hair, truth, None, None, None, None, **{"gravity": G, **settings})


def test_errors_are_root_mean_squares_over_frames():
    moved = frames(Reached, hanging(), hanging(shift=3e-3), hanging(shift=-4e-3), hanging())
    table = measured(moved)
    rms = np.sqrt((9.0 + 16.0) / 3)
    assert table["tip error [mm]"][0] == pytest.approx(rms, rel=1e-4)
    assert table["strand error [% of length]"][0] == pytest.approx(rms / 2, rel=1e-4)
    assert table["largest error [mm]"][0] == pytest.approx(4.0, rel=1e-4)
    assert table["energy error [% of m g L]"][0] == pytest.approx(0.0, abs=1e-4)
    assert table["failed"] == ("",) and np.isnan(table["deepest [mm]"][0])


def test_energy_is_that_of_motion_and_weight():
    table = measured(frames(Reached, *[hanging(speed=0.6)] * 4))
    assert table["energy error [% of m g L]"][0] == pytest.approx(100 * 0.5 * 0.36 / (G * L), rel=1e-4)
    assert measured(frames(Reached, *[hanging(speed=0.6)] * 4), gravity=0.0)["energy error [% of m g L]"][0] == 0.0


def test_hair_fails_where_it_first_stretches():
    wild = frames(Reached, hanging(), hanging(), hanging(stretch=0.2), hanging(stretch=0.1001))
    table = measured(wild)
    assert table["failed"] == ("stretched by more than 10 % at frame 3",)
    assert table["stretch [%]"][0] == pytest.approx(20.0, rel=1e-4)
    assert table["largest error [mm]"][0] == pytest.approx(0.2 * L / 4 * 1e3, rel=1e-4)
    assert measured(wild, bound=0.3)["failed"] == ("",)


def test_hair_fails_where_it_is_not_finite():
    table = measured(frames(Reached, hanging(), hanging(shift=1e-3)))
    assert table["failed"] == ("not finite at frame 3",) and np.isinf(table["tip error [mm]"][0])
    assert table["stretch [%]"][0] == pytest.approx(0.0, abs=1e-3)


def test_depth_is_that_in_the_body(sphere):
    ball = frames(Frames, *[bake(sphere(0.05, (0.0, -0.24, 0.0)), 0.0025, 8.0)] * 4)
    truth = frames(Frames, *[hanging()] * 4)
    table = measure_fidelity(frames(Reached, *[hanging()] * 4), truth, None, None, (ball,), None)
    assert table["deepest [mm]"][0] == pytest.approx(10.0, abs=0.1)


def test_strands_that_are_omitted_are_compared_by_ids():
    two = lay_strands(2, L, 4, DOWN, (0.01, 0.0, 0.0), None, 0.0)
    both = Strands(two.points.astype(np.float32), np.zeros((10, 3), np.float32), two.offsets, 8e-5)
    one = lay_strands(1, L, 4, DOWN, (0.01, 0.0, 0.0), None, 0.0)
    one.ids[:] = 1
    hair, truth = frames(Reached, *[hanging(shift=0.01)] * 2), frames(Frames, both, both)
    assert measure_fidelity(hair, truth, one, two, None, None)["largest error [mm]"][0] == pytest.approx(0.0, abs=1e-4)
    with pytest.raises(BadInput, match="do not correspond"):
        measure_fidelity(hair, truth, None, None, None, None)
    one.ids[:] = 7
    with pytest.raises(BadInput, match="no strand with id 7"):
        measure_fidelity(hair, truth, one, two, None, None)


@pytest.mark.parametrize("height", [0.0, 1.65])
def test_energy_does_not_depend_on_how_high_hair_is(height):
    """A strand that is longer by 1 % all along hangs lower by half of that."""

    def raised(long):
        points = (hanging().points * [1.0, long, 1.0] + [0.0, height, 0.0]).astype(np.float32)
        return Strands(points, np.zeros_like(points), np.array([0, 5], np.int32), 8e-5)

    hair, truth = frames(Reached, *[raised(1.01)] * 2), frames(Frames, *[raised(1.0)] * 2)
    table = measure_fidelity(hair, truth, None, None, None, None, gravity=G)
    assert table["energy error [% of m g L]"][0] == pytest.approx(0.5, rel=1e-3)
