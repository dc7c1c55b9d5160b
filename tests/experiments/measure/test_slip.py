"""Slip is what hair moves beside what carries it."""

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.engine import Frames, Time
from hairpipe.graphs.experiments.nodes.measure_slip import measure_slip
from hairpipe.groom.strands import lay_strands
from hairpipe.values import Strands

GROOM = lay_strands(2, 0.1, 10, (0.0, 0.0, 1.0), (0.05, 0.0, 0.0), None, 0.0)


def test_hair_that_is_carried_does_not_slip_and_what_slips_is_seen():
    track = Track((0.0, 1.0), turn=(0.0, 45.0), axis=(0.0, 0.0, 1.0), pivot=(0.3, -0.1, 0.0), ease="linear")
    ends = {n: drive(GROOM, n / 10, track, None, None, None) for n in (0, 5, 10)}

    def hair(n):
        strands = np.repeat([0, 1], 11)
        turn, shift = ends[n].roots[strands, :, :3], ends[n].roots[strands, :, 3]
        own = GROOM.points + (n == 10) * np.array([0.002, 0.0, 0.0])
        points = (np.einsum("pij,pj->pi", turn, own) + shift).astype(np.float32)
        points[21] += np.float32(0.001) * np.array([0, 0, n == 5], np.float32)
        return Strands(points, points * 0, GROOM.offsets, 8e-5)

    table = measure_slip(Frames((0, 5, 10), hair), Frames((0, 5, 10), ends.__getitem__), Time(0, 10.0))
    assert table["slope [1]"] == pytest.approx(np.tan(np.radians([0, 0, 22.5, 22.5, 45, 45])), abs=1e-12)
    assert table["tip slipped [mm]"] == pytest.approx([0, 0, 0, 1, 2, 2], abs=1e-4)
    assert table["slipped [mm]"] == pytest.approx([0, 0, 0, np.sqrt(1 / 11), 2, 2], abs=1e-4)
    assert table["time [s]"] == pytest.approx([0, 0, 0.5, 0.5, 1, 1])
