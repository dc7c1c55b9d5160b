"""Motion, swing, tension and values at points of hair."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.engine import Frames, Time
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.tensions import turns
from hairpipe.graphs.experiments.nodes.measure_tension import measure_tension
from hairpipe.groom.strands import lay_strands
from hairpipe.laws.settings import Rest, Share
from hairpipe.levelset.bake import bake
from hairpipe.measure.contact import still
from hairpipe.measure.motion import measure_points, swing_table, tensions
from hairpipe.nodes.measure_motion import measure_motion
from hairpipe.nodes.watch_hair import watch_hair
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import start
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
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


AROUND = np.arange(0, 45, 9, dtype=np.int32)


def hair_at(led, swung):
    """Four strands that hang around a head somewhere, whose roots and lower quarters have turned by angles [rad]."""
    points = np.empty((36, 3))
    for k in range(36):
        strand, part = divmod(k, 9)
        angle = strand * np.pi / 2 + 0.3 + (swung if part >= 7 else led)
        points[k] = 0.7 + 0.1 * np.sin(angle), -0.03 * part, -0.2 + 0.1 * np.cos(angle)
    return Strands(points, np.zeros((36, 3), np.float32), AROUND, 1e-4)


@pytest.mark.parametrize("lag", [0.0, 2.6])
def test_it_is_how_far_hair_turns_and_how_long_after_its_roots(lag):
    at = {1001 + k: k / 24 for k in range(48)}
    hair = {
        frame: hair_at(0.9 * np.sin(8.0 * t), 0.4 * np.sin(8.0 * (t - lag / 24)) if t > lag / 24 else 0.0)
        for frame, t in at.items()
    }
    row = next(swing_table(hair).rows())
    assert row[0] == pytest.approx(lag, abs=0.15) and row[1] > 0.99
    assert row[2:] == pytest.approx(np.degrees((0.8, 1.8)), rel=1e-2)


def test_roots_at_rest_drive_nothing():
    with pytest.raises(BadInput, match="the roots of the hair do not turn"):
        swing_table(dict.fromkeys(range(4), hair_at(0.0, 0.0)))


HANGING = lay_strands(11, 0.2, 20, (0.0, -1.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)


def hair_of(groom, points):
    return Strands(points, np.zeros(points.shape, np.float32), groom.offsets, 8e-5)


def test_tension_is_the_weight_below_and_stretch_the_change_of_length():
    state = start(build_hair(HANGING, Material(), "network"), None, Scene(rest=Rest(balanced=Share(1.0))))
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


def test_a_chain_pulls_with_its_edges():
    hair = build_hair(HANGING, Material(), "chain")
    state = start(hair, None, Scene())
    pulled = replace(state, tensions=np.zeros_like(state.tensions))
    pulled.tensions[:, 0] = 3e-6
    for _, _, pulls in tensions(hair.layout, pulled):
        np.testing.assert_allclose(pulls, 3e-6, rtol=1e-12)


def test_the_table_has_a_row_for_every_segment_and_knows_turns():
    arc = lay_strands(1, 0.1, 20, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.4)
    hair = build_hair(arc, Material(), "network")
    state = start(hair, None, Scene())
    led = replace(state, positions=state.positions + np.array([0.0, 0.003, 0.004])[:, None])
    states = {3: state, 4: state, 6: led}
    table = measure_tension(arc, Frames((3, 4, 6), states.__getitem__), Time(3, 10.0))
    assert table["root moved [mm]"][[0, 20, 40]] == pytest.approx([0.0, 0.0, 5.0])
    assert len(table) == 60 and table["time [s]"][[0, 20, 40]] == pytest.approx([0.0, 0.1, 0.3])
    edges = np.diff(arc.points, axis=0)
    between = np.degrees(np.arccos(edges[0] @ edges[-1] / 0.005**2))
    assert table["turned [deg]"][19] == pytest.approx(between, rel=1e-6) and table["turned [deg]"][0] == 0.0
    assert table["arc [m]"][:2] == pytest.approx([0.0025, 0.0075])
    assert not np.asarray(table["tension [uN]"]).any()
    frames = Frames((3, 4, 6), states.__getitem__)
    assert len(measure_tension(arc, frames, Time(3, 10.0), moments=(4, 9))) == 20
    assert len(measure_tension(arc, frames, Time(3, 10.0), moments=(9,))) == 60


def test_wriggles_are_not_turns():
    angle = np.radians(np.linspace(0.0, 180.0, 91) + 20.0 * np.sin(np.linspace(0.0, 40.0, 91)) ** 2)
    wriggly = np.cumsum(np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)]), axis=0)
    assert turns(wriggly)[-1] == pytest.approx(np.degrees(angle[-1] - angle[1]), abs=1e-6)
