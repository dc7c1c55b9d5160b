"""The table of strands over time says what was done to them."""

import numpy as np
import pytest
from hairpipe.nodes.measure_strands import measure_strands

from hairpipe.data import Strands
from hairpipe.graph import Frames, Time

OFFSETS = np.array([0, 11, 16], np.int32)
REST = np.concatenate([np.linspace([0, 0, 0], [0.1, 0, 0], 11), np.linspace([0, 1, 0], [0, 1, 0.04], 5)])


def strands(points: np.ndarray, velocity: float = 0.0) -> Strands:
    velocities = np.zeros((16, 3), np.float32)
    velocities[3] = (0.0, 0.0, velocity)
    return Strands(points.astype(np.float32), velocities, OFFSETS, 80e-6)


def test_every_strand_has_a_row_for_every_frame():
    stretched, bent = REST * [1.2, 1.0, 1.0], REST.copy()
    bent[4] += [0.002, 0.0, 0.0]
    values = {
        8: strands(REST),
        9: strands(stretched, 3.0),
        11: strands(bent),
        12: strands(REST + np.array([0.003, 0.0, 0.004])),
    }
    table = measure_strands(Frames(tuple(values), values.__getitem__), Time(8, 25.0))
    assert table["time [s]"] == pytest.approx(np.repeat([0.0, 0.04, 0.12, 0.16], 2))
    assert table["strand"].tolist() == [0, 1] * 4
    assert table["stretch [%]"] == pytest.approx([0, 0, 20, 0, 0, 0, 0, 0], abs=1e-3)
    assert table["segment strain [%]"] == pytest.approx([0, 0, 20, 0, 20, 0, 0, 0], abs=1e-2)
    assert table["fastest point [m/s]"].tolist() == [0, 0, 3, 0, 0, 0, 0, 0]
    assert table["moved [mm]"][-2:] == pytest.approx([5.0, 5.0], abs=1e-4)
    assert table["span [m]"][:3] == pytest.approx([0.1, 0.04, 0.12])
    assert [table[f"tip {axis} [m]"][1] for axis in "xyz"] == pytest.approx([0.0, 1.0, 0.04])
    assert not table["writhe [1]"].any()
