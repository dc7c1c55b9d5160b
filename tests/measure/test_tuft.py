"""Clumps are told from lattices and from chance."""

import numpy as np
import pytest

from hairpipe.engine import Frames, Time
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.measure_tuft import measure_tuft
from hairpipe.groom.strands import lay_strands
from hairpipe.nodes.measure_crossing import measure_crossing
from hairpipe.values import Strands


def hanging(tips):
    """Straight strands that hang side by side, at places (S, 2)."""
    roots = np.column_stack([tips[:, 0], 0 * tips[:, 0], tips[:, 1]])
    points = roots[:, None] + np.linspace(0.0, 1.0, 6)[:, None] * [0.0, -0.3, 0.0]
    offsets = np.arange(0, 6 * len(tips) + 1, 6).astype(np.int32)
    flat = points.reshape(-1, 3).astype(np.float32)
    return Strands(flat, flat * 0, offsets, 8e-5)


def test_lattice_chance_and_clumps():
    chance = np.random.default_rng(2)
    side = np.arange(30) * 0.002
    lattice = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    r, angle = 0.03 * np.sqrt(chance.uniform(size=900)), chance.uniform(0, 2 * np.pi, 900)
    strewn = np.column_stack([r * np.cos(angle), r * np.sin(angle)])
    pairs = np.repeat(strewn[::2], 2, axis=0) + np.tile([[0.0, 0.0], [1e-4, 0.0]], (450, 1))
    values = {n: hanging(tips) for n, tips in enumerate((lattice, strewn, pairs, 0.5 * strewn))}
    table = measure_tuft(Frames(tuple(values), values.__getitem__), Time(0, 24.0))
    assert table["nearest strand [mm]"][0] == pytest.approx(2.0, rel=1e-4)
    assert table["nearest strand [mm]"][2] == pytest.approx(0.1, rel=0.05)
    assert table["over random [1]"] == pytest.approx([1.95, 1.0, 0.1 / 0.886, 1.0], rel=0.05)
    assert table["spread of tips [mm]"][1] == pytest.approx(0.03e3 / np.sqrt(2), rel=0.03)
    assert table["spread of tips [mm]"][3] == pytest.approx(0.5 * table["spread of tips [mm]"][1], rel=1e-5)


def test_single_strand_is_not_a_tuft():
    values = {1: hanging(np.zeros((1, 2)))}
    with pytest.raises(BadInput, match="a tuft needs more than one strand"):
        measure_tuft(Frames((1,), values.__getitem__), Time(1, 24.0))
    values = {1: hanging(np.zeros((2, 2)))}
    together = measure_tuft(Frames((1,), values.__getitem__), Time(1, 24.0))
    assert together["nearest strand [mm]"].tolist() == [0.0]


def test_hairs_that_lean_across_the_other_lock_have_crossed_it():
    """Two locks of four hairs; one hair of the first crosses all of the second at about 0.55 of its length."""
    side = np.column_stack([[0.0, 1e-3, 2e-3, 3e-3, 0.1, 0.101, 0.102, 0.103], np.zeros(8)])
    apart, leaning = hanging(side), hanging(side)
    points = leaning.points.reshape(8, 6, 3)
    points[2, :, 0] += np.float32(np.linspace(0.0, 0.18, 6))
    values = {1: apart, 2: leaning}
    lock = lay_strands(4, 0.3, 5, (0.0, -1.0, 0.0), (1e-3, 0.0, 0.0), None, 0.0)
    table = measure_crossing(Frames((1, 2), values.__getitem__), lock, Time(1, 24.0))
    levels = np.linspace(0.5, 1.0, 9)
    exact = np.mean([(2e-3 + 0.18 * level > side[4:, 0]).sum() for level in levels]) / 16.0
    assert table["crossed pairs [%]"] == pytest.approx([0.0, 100.0 * exact])
    assert table["crossed hairs [%]"] == pytest.approx([0.0, 100.0 / 8.0])
    with pytest.raises(BadInput, match="4 of 4 strands"):
        measure_crossing(Frames((1,), {1: hanging(side[:4])}.__getitem__), lock, Time(1, 24.0))
