"""Tables of strands over time: writhe, slip, curls and rest."""

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.engine import Frames, Time
from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, turn_of
from hairpipe.graphs.experiments.measure.curls import radius
from hairpipe.graphs.experiments.measure.invariance import differences
from hairpipe.graphs.experiments.measure.rest import rest_table
from hairpipe.graphs.experiments.measure.strands import bulge, turns
from hairpipe.graphs.experiments.measure.writhe import writhe
from hairpipe.graphs.experiments.nodes.measure_curls import measure_curls
from hairpipe.graphs.experiments.nodes.measure_slip import measure_slip
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


def helix(turns: float, radius: float, pitch: float, count: int) -> np.ndarray:
    """A right-handed helix, (count, 3)."""
    angle = np.linspace(0.0, 2 * np.pi * turns, count)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), pitch * angle / (2 * np.pi)])


def gauss(points: np.ndarray) -> float:
    """The double integral over the midpoints of segments."""
    middle, step = (points[1:] + points[:-1]) / 2, np.diff(points, axis=0)
    away = middle[:, None] - middle[None]
    distance = np.linalg.norm(away, axis=2)
    np.fill_diagonal(distance, np.inf)
    volume = np.einsum("ijk,ijk->ij", away, np.cross(step[:, None], step[None]))
    return float(np.sum(volume / distance**3) / (4 * np.pi))


def test_a_long_helix_gives_the_known_value_for_every_turn():
    for pitch in (3.0, 8.0):
        rise = pitch / np.hypot(pitch, 2 * np.pi)
        more = writhe(helix(24, 1.0, pitch, 961)) - writhe(helix(16, 1.0, pitch, 641))
        assert more / 8 == pytest.approx(1 - rise, abs=2e-3)


def test_it_is_the_double_integral():
    curve = np.cumsum(np.random.default_rng(3).normal(size=(9, 3)), axis=0)
    smooth = np.column_stack([np.interp(np.linspace(0, 8, 1201), np.arange(9), curve[:, k]) for k in range(3)])
    assert writhe(curve) == pytest.approx(gauss(smooth), abs=3e-3)
    assert writhe(curve) == pytest.approx(writhe(smooth[::40]), abs=1e-2)
    assert abs(writhe(curve)) > 0.1


def test_a_mirror_turns_its_sign_and_nothing_else_changes_it():
    curve = helix(2.3, 0.01, 0.012, 60)
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    value = writhe(curve)
    assert value > 0.5
    assert writhe(curve @ turn * 7 + [1, 2, 3]) == pytest.approx(np.sign(np.linalg.det(turn)) * value)
    assert writhe(curve[::-1]) == pytest.approx(value)
    assert writhe(curve * [1, 1, -1]) == pytest.approx(-value)


def test_plane_curves_have_no_writhe():
    angle = np.linspace(0.0, 9.0, 80)
    assert writhe(np.column_stack([angle * np.cos(angle), np.sin(angle), 0 * angle])) == 0.0
    assert writhe(np.zeros((1, 3))) == 0.0
    assert writhe(np.linspace([0, 0, 0], [1, 2, 3], 20)) == 0.0


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


def curls_of(width, pitch=0.02, segments=80):
    return lay_strands(1, 0.25, segments, (1.0, 2.0, 0.3), (0.0, 0.0, 0.01), Helix(width, pitch), 0.0).points


@pytest.mark.parametrize("width", [0.003, 0.006, 0.012])
def test_a_helix_has_its_own_radius(width):
    points = curls_of(width)
    turn = turn_of(points)
    assert turn * 0.25 / 80 == pytest.approx(np.hypot(2 * np.pi * width, 0.02), rel=0.06)
    assert radius(points, turn) == pytest.approx(width, rel=0.02)


def test_a_bent_helix_keeps_its_radius():
    points = curls_of(0.004, segments=200)
    axis = np.array([1.0, 2.0, 0.3]) / np.linalg.norm([1.0, 2.0, 0.3])
    height = points @ axis
    bent = points + np.outer(4.0 * height**2, [0.0, 0.0, 1.0])
    assert radius(bent, turn_of(points)) == pytest.approx(radius(points, turn_of(points)), rel=0.03)


def test_it_is_followed_over_time_and_straight_strands_do_not_count():
    straight = np.linspace([0, 0, 0], [0, 0.2, 0], 81)
    offsets = np.array([0, 81, 162], np.int32)

    def hair(scale):
        middle = curls_of(0.006).mean(axis=0)
        axis = np.array([1.0, 2.0, 0.3]) / np.linalg.norm([1.0, 2.0, 0.3])
        along = np.outer((curls_of(0.006) - middle) @ axis, axis) + middle
        points = np.concatenate([straight, along + scale * (curls_of(0.006) - along)]).astype(np.float32)
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


LINE = np.array([[0.0, 0.0, 0.0], [0.1, 0.02, 0.03]])
LENGTH = float(np.linalg.norm(LINE[1]))


def line_at(points, speed=0.0):
    """A strand whose points all have a velocity along X [m/s]."""
    velocities = np.zeros_like(points, np.float32)
    velocities[:, 0] = speed
    return Strands(np.array(points), velocities, np.array([0, 2]), 80e-6)


def test_drift_and_speeds_are_those_of_the_motion():
    moving = {frame: line_at(np.add(LINE, [0.001 * frame, 0.0, 0.0]), speed=0.025) for frame in range(1, 50)}
    (row,) = rest_table(moving, line_at(LINE), 24.0, 1.0).rows()
    drift, speed, reported, apart, error = row
    assert (drift, speed, reported) == pytest.approx((24.0, 24.0, 25.0), rel=1e-6)
    assert apart == pytest.approx(1.0, rel=1e-5) and error == pytest.approx(4.9 / LENGTH)
    assert np.isnan(next(rest_table(moving, None, 24.0, 1.0).rows())[-1])


@pytest.mark.parametrize("seconds", [0.01, 3.0])
def test_a_duration_that_the_hair_does_not_have_is_refused(seconds):
    moving = {frame: line_at(LINE) for frame in range(1, 50)}
    with pytest.raises(BadInput, match="frames of 49"):
        rest_table(moving, None, 24.0, seconds)


def test_a_mirrored_and_scaled_scene_is_the_same():
    truth = {frame: line_at(LINE * frame) for frame in range(1, 10)}
    large = {frame: line_at(4.0 * LINE * (1.0 + 0.5 * (frame - 1)) * [1.0, 1.0, -1.0]) for frame in range(1, 10)}
    found = differences(large, truth, 24.0, "z", 4.0, 2)
    assert len(found) == 5 and found.numbers["difference [% of length]"].max() < 1e-12
    assert differences(large, truth, 24.0, None, 4.0, 2).numbers["difference [% of length]"].min() > 10.0


def test_other_strands_are_refused():
    three = Strands(np.zeros((3, 3)), np.zeros((3, 3), np.float32), np.array([0, 3]), 80e-6)
    with pytest.raises(BadInput, match="3 and 2 points"):
        differences({1: three}, {1: line_at(LINE)}, 24.0, None, 1.0, 1)
