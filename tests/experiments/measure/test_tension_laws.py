"""A rope around a post, and a bar on a floor: tensions of theory have no error, others have theirs."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.engine import Frames, Time
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.pulls import Bar
from hairpipe.graphs.experiments.nodes.measure_pull import measure_pull
from hairpipe.graphs.experiments.nodes.measure_wrap import measure_wrap
from hairpipe.groom.strands import lay_strands
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import start
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

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
