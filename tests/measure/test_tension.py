"""The tension of hair that hangs at rest is the weight of what hangs below."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.engine import Frames, Time
from hairpipe.graphs.experiments.measure.tensions import turns
from hairpipe.graphs.experiments.nodes.measure_tension import measure_tension
from hairpipe.groom.strands import lay_strands
from hairpipe.laws.settings import SagFree
from hairpipe.measure.motion import tensions
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import start
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

HANGING = lay_strands(11, 0.2, 20, (0.0, -1.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)


def test_it_is_the_weight_below():
    hair = build_hair(HANGING, Material(), "network")
    state = start(hair, None, Scene(sag_free=SagFree()))
    weight = Material().line_density * 9.81
    found = tensions(hair.layout, state)
    assert sorted(strand for strand, _, _ in found) == list(range(11))
    for strand, points, pulls in found:
        assert points[0] == pytest.approx([0.0, 0.0, 0.01 * strand], abs=1e-12)
        middles = 0.01 * (np.arange(20) + 0.5)
        np.testing.assert_allclose(pulls, weight * (0.2 - middles), atol=0.03 * weight * 0.2)
        assert pulls[0] == pytest.approx(weight * 0.195, rel=0.02)


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
