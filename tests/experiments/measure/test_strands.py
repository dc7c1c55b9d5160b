"""The table of strands over time says what was done to them."""

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.engine import Frames, Time
from hairpipe.graphs.experiments.measure.strands import bulge, turns
from hairpipe.graphs.experiments.nodes.measure_strands import measure_strands
from hairpipe.groom.strands import lay_strands
from hairpipe.values import Strands

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
    table = measure_strands(Frames(tuple(values), values.__getitem__), None, Time(8, 25.0))
    assert table["time [s]"] == pytest.approx(np.repeat([0.0, 0.04, 0.12, 0.16], 2))
    assert table["strand"].tolist() == [0, 1] * 4
    assert table["stretch [%]"] == pytest.approx([0, 0, 20, 0, 0, 0, 0, 0], abs=1e-3)
    assert table["segment strain [%]"] == pytest.approx([0, 0, 20, 0, 20, 0, 0, 0], abs=1e-2)
    assert table["fastest point [m/s]"].tolist() == [0, 0, 3, 0, 0, 0, 0, 0]
    assert table["moved [mm]"][-2:] == pytest.approx([5.0, 5.0], abs=1e-4)
    assert table["span [m]"][:3] == pytest.approx([0.1, 0.04, 0.12])
    assert [table[f"tip {axis} [m]"][1] for axis in "xyz"] == pytest.approx([0.0, 1.0, 0.04])
    assert table["bulge [m]"] == pytest.approx([0] * 8, abs=1e-8)
    assert not table["writhe [1]"].any()


def test_bulge_is_the_greatest_distance_from_the_line_between_the_ends():
    angle = np.linspace(0.0, 1.2, 401)
    arc = np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])
    assert bulge(arc) == pytest.approx(1 - np.cos(0.6), rel=1e-4)
    assert bulge(np.array([[0, 0, 0], [0, 3, 4], [0, 0, 0]])) == 5.0


def test_tips_are_turned_as_far_as_they_are_led():
    groom = lay_strands(2, 0.1, 5, (1.0, 0.5, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    spin = Track((0.0, 1.0), turn=(0.0, -1000.0), axis=(1.0, 0.5, 0.0), ease="linear")
    roots = Track((0.0, 1.0), turn=(0.0, 200.0), axis=(1.0, 0.5, 0.0), ease="linear")
    ends = [drive(groom, n / 24, roots, None, spin, 1.0) for n in range(26)]
    angles = turns(ends, groom.points[[5, 11]] - groom.points[[0, 6]])
    assert angles[:25] == pytest.approx(np.radians(-1200.0) * np.arange(25)[:, None] / 24 * [1, 1], abs=1e-12)
    assert np.isnan(angles[25]).all()
    values = {n: Strands(groom.points.astype(np.float32), groom.points * 0, groom.offsets, 8e-5) for n in (1, 2)}
    led = {1: ends[0], 2: ends[1]}
    table = measure_strands(Frames((1, 2), values.__getitem__), Frames((1, 2), led.__getitem__), Time(1, 24.0))
    assert table["turned [rad]"] == pytest.approx([0, 0, *np.radians([-50.0, -50.0])])
