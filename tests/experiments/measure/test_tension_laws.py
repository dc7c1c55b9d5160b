"""A rope around a post, a bar on a floor, beams that press on each other: theory has no error, others have theirs."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.engine import Frames, Time
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.pulls import Bar
from hairpipe.graphs.experiments.nodes.measure_beams import measure_beams
from hairpipe.graphs.experiments.nodes.measure_pull import measure_pull
from hairpipe.graphs.experiments.nodes.measure_wrap import measure_wrap
from hairpipe.groom.strands import lay_strands
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import start
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Strands

GROOM = lay_strands(1, 0.1, 20, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
TIME = Time(1, 10.0)
UP = np.array([0.0, 1.0, 0.0])


def state_of(points, pulls):
    """Return a chain at points [m], (21, 3), with tensions of its segments [N], (20,)."""
    state = start(build_hair(GROOM, Material(), "chain"), None, Scene())
    changed = replace(state, positions=state.positions.copy(), tensions=state.tensions.copy())
    changed.positions[1:] = points[:, :, None]  # below the row that continues the root
    changed.tensions[1:21, 0] = pulls[:, None]
    return changed


def test_a_rope_around_a_post_has_the_ratio_of_euler_and_eytelwein():
    angles = np.radians(np.clip(np.arange(20) - 4, 0, 10) * 18.0)
    points = np.cumsum([[0.0, 0.0, 0.0], *0.005 * np.stack([np.sin(angles), np.cos(angles), 0 * angles], 1)], axis=0)
    states = {n: state_of(points + 1e-3 * n * UP, 1e-4 * np.exp(-0.3 * angles)) for n in (1, 2, 5)}
    frames = Frames((1, 2, 5), states.__getitem__)
    table = measure_wrap(GROOM, frames, TIME, friction=0.3, first=0.05)
    assert table["turned [deg]"] == pytest.approx([180.0, 180.0])
    assert table["ratio [1]"] == pytest.approx(2 * [np.exp(0.3 * np.pi)])
    assert table["ratio error [%]"] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert table["tip moved [mm]"] == pytest.approx([0.0, 3.0], abs=1e-9)
    assert measure_wrap(GROOM, frames, TIME, friction=0.2)["ratio error [%]"][0] == pytest.approx(36.9, abs=0.1)
    with pytest.raises(BadInput, match="no frame"):
        measure_wrap(GROOM, frames, TIME, friction=0.3, first=7.0)


@pytest.mark.parametrize("pulled", [1e-7, 1.5e-6, 3e-6])
def test_the_end_of_a_bar_on_a_floor_has_moved_by_the_elongation_of_what_slides(pulled):
    bar = Bar(0.1, 7e-5, 3e-5)
    arcs = np.linspace(0.0, 0.1, 20001)
    tension = np.maximum(pulled - bar.grip * arcs, 0.0)
    moved = float(np.mean(tension)) * 0.1 / bar.axial
    assert bar.force(moved, 0.0) == pytest.approx(pulled, rel=1e-3)
    assert bar.force(moved, 0.02) == pytest.approx(np.interp(0.02, arcs, tension), rel=1e-3, abs=1e-10)
    assert bar.force(1.0, 0.0) == pytest.approx(3e-6)


def test_the_table_has_the_difference_from_the_bar():
    material = Material(young=1.36e6, softening=100.0)
    bar = Bar(0.1, material.axial, 0.5 * material.line_density * 9.81)
    arcs = 0.005 * (np.arange(20) + 0.5)
    states = {}
    for n, moved in ((1, 0.0), (2, 0.001), (3, 0.01)):
        pulls = np.array([bar.force(moved, arc) for arc in arcs])
        states[n] = state_of(GROOM.points - [moved, 0.0, 0.0], pulls + (n == 3) * 0.01 * bar.force(1.0, arcs[1]))
    frames = Frames((1, 2, 3), states.__getitem__)
    table = measure_pull(GROOM, frames, TIME, friction=0.5, material=material)
    assert table["root moved [mm]"] == pytest.approx([0.0, 1.0, 10.0])
    assert table["difference [% of the sliding force]"] == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)


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
