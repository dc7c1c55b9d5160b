"""Beams of theory that press on each other are in balance; one that is bent too far is not."""

import numpy as np
import pytest

from hairpipe.engine import Frames
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.measure_beams import measure_beams
from hairpipe.strands.material import Material
from hairpipe.values import Strands

THICKNESS, FORCE, ARMS = 3e-4, 4e-7, (0.06, 0.04)
ALONG = np.linspace(0.0, 1.0, 41)


def deflected(arc, arm, force):
    """Return the deflection of a clamped beam with a force at an arm (Timoshenko, Strength of Materials)."""
    near = np.minimum(arc, arm)
    return force * near**2 * (3.0 * arm - near + 3.0 * (arc - near)) / (6.0 * Material().bending)


def pair(force, low):
    """Two beams whose undeflected axes are 1 mm apart, or closer than THICKNESS by what both are bent."""
    x, z = 0.08 * ALONG, 0.06 * ALONG
    gap = 1e-3 if force == 0.0 else THICKNESS - sum(deflected(arm, arm, force) for arm in ARMS)
    first = np.stack([x, -low * deflected(x, ARMS[0], force), 0 * x], axis=1)
    second = np.stack([0 * z + ARMS[0], gap + deflected(z, ARMS[1], force), z - ARMS[1]], axis=1)
    points = np.concatenate([first, second])
    return Strands(points, np.zeros_like(points, np.float32), np.array([0, 41, 82], np.int32), 8e-5)


def test_forces_of_beams_are_those_of_theory_and_an_imbalance_is_seen():
    for low in (1.0, 1.1):
        table = measure_beams(Frames((1, 5), {1: pair(0.0, 1.0), 5: pair(FORCE, low)}.__getitem__), thickness=THICKNESS)
        assert table["arm [m]"] == pytest.approx(ARMS)
        assert table["force [uN]"] == pytest.approx([1e6 * FORCE * low, 1e6 * FORCE], rel=2e-3)
        assert table["deflection error [%]"] == pytest.approx([100 * (low - 1.0), 0.0], abs=0.2)
        assert table["imbalance [%]"] == pytest.approx([100 * (low - 1.0), 100 * (1 / low - 1.0)], abs=0.4)


def test_strands_that_do_not_cross_are_refused():
    apart = pair(0.0, 1.0)
    apart.points[41:, 0] += 0.05
    with pytest.raises(BadInput, match="do not cross"):
        measure_beams(Frames((1,), lambda _: apart), thickness=THICKNESS)
