"""One strand in several orientations."""

import numpy as np

from hairpipe.graphs.experiments.studies.accuracy.fan import fan_table, fanned
from hairpipe.groom.strands import lay_strands
from hairpipe.values import Strands


def test_fan_of_equal_strands_reports_the_largest_difference():
    one = lay_strands(1, 0.1, 4, (1.0, 0.5, 0.0), (0.0, 0.0, 0.0), None, 0.2)
    fan = fanned(one, 9, 0.01)
    strands = fan.points.reshape(9, 5, 3)
    np.testing.assert_allclose(np.diff(strands[0], axis=0), np.diff(one.points, axis=0), atol=1e-15)
    np.testing.assert_allclose(fan.root_frames[:, :, 3], strands[:, 0])
    np.testing.assert_allclose(np.linalg.norm(strands[:, 0], axis=1), 0.01)
    np.testing.assert_allclose(np.linalg.norm(strands[1, 1] - strands[0, 1]), 2 * np.sin(np.pi / 9) * strands[0, 1, 0])
    bent = fan.points.copy()
    bent[-1, 1] += 2e-3
    shot = {
        n: Strands(points, np.zeros_like(points, np.float32), fan.offsets, 8e-5)
        for n, points in ((5, fan.points), (17, bent))
    }
    table = fan_table(shot, 24.0)
    np.testing.assert_allclose(table["time [s]"], [0.0, 0.5])
    np.testing.assert_allclose(table["difference [% of length]"], [0.0, 2.0], atol=1e-12)
