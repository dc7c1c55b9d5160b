"""Speed, stretch and height of hair as a whole."""

import numpy as np
import pytest

from hairpipe.engine import Frames, Time
from hairpipe.nodes.measure_motion import measure_motion
from hairpipe.nodes.watch_hair import watch_hair
from hairpipe.values import Groom, Strands

POINTS = np.array([[0, 0, 0], [0, -1, 0], [0, -2, 0], [1, 0, 0], [1, -2, 0]], np.float32)
OFFSETS = np.array([0, 3, 5], np.int32)
SPEEDS = np.array([[9, 9, 9], [3, 4, 0], [0, 0, 0], [9, 9, 9], [0, 0, 12]], np.float32)

NONE = np.zeros(0)
GROOM = Groom(POINTS.astype(float), OFFSETS, NONE, NONE, NONE, NONE, NONE)


def test_motion_excludes_prescribed_roots():
    moved = POINTS.copy()
    moved[2, 1], moved[4, 1] = -2.5, -1.0
    hair = {3: Strands(POINTS, SPEEDS, OFFSETS, 8e-5), 4: Strands(moved, 0 * SPEEDS, OFFSETS, 8e-5)}
    table = measure_motion(Frames((3, 4), hair.__getitem__), Time(0, 24.0), ())
    assert table["time [s]"].tolist() == pytest.approx([0.0, 1 / 24])
    assert table["rms speed [mm/s]"].tolist() == pytest.approx([1e3 * np.sqrt((25 + 144) / 3), 0.0])
    assert table["fastest [mm/s]"].tolist() == pytest.approx([12e3, 0.0])
    assert table["longest stretch [%]"].tolist() == pytest.approx([0.0, 25.0])
    assert table["mean height [mm]"].tolist() == pytest.approx([-5e3 / 3, -1.5e3])
    assert table["moved [mm]"].tolist() == pytest.approx([0.0, 1e3 * np.sqrt((0.25 + 1.0) / 3)])
    assert table["moved farthest [mm]"].tolist() == pytest.approx([0.0, 1e3])


def test_one_frame_is_watched_against_the_groom():
    stretched = POINTS.copy()
    stretched[2, 1], stretched[4, 1] = -2.5, -1.0
    table = watch_hair(Strands(stretched, SPEEDS, OFFSETS, 8e-5), GROOM)
    assert len(table) == 1 and table["longest stretch [%]"][0] == pytest.approx(25.0)
    assert table["fastest [mm/s]"][0] == pytest.approx(12e3) and table["mean height [mm]"][0] == pytest.approx(-1.5e3)
