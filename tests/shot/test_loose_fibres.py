"""The wind takes hold of all the fibre that particles stand for."""

import numpy as np
import pytest

from hairpipe.laws.drag import law_of, normal_drag
from hairpipe.laws.settings import Shielding, Wind
from hairpipe.shot.breeze import LooseFibres, add_wind

SEGMENT, DIAMETER = 0.02, 80e-6


def forces_of(wind, points, counts):
    down, still = np.tile([0.0, -1.0, 0.0], (len(points), 1)), np.zeros((len(points), 3))
    push, drag = np.zeros((len(points), 3)), np.zeros((len(points), 6))
    add_wind(wind, LooseFibres(points, down, still, np.asarray(counts, float), SEGMENT, DIAMETER), 0.0, push, drag)
    return push, drag


def test_across_the_hair_it_pushes_as_on_a_cylinder_of_all_that_length():
    wind = Wind((0.0, 0.0, -2.0))
    push, drag = forces_of(wind, np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), [40, 90])
    expected = np.array([40, 90]) * SEGMENT * normal_drag(law_of(wind, DIAMETER), 2.0)
    assert push == pytest.approx(-2.0 * expected[:, None] * (0.0, 0.0, 1.0), abs=1e-15)
    assert drag[:, [0, 5]] == pytest.approx(np.stack([expected, expected], axis=1))


def test_hair_keeps_the_wind_from_the_hair_behind_it():
    points = np.zeros((400, 3))
    points[:, 2] = -np.linspace(0.0, 0.1, 400)
    push, _ = forces_of(Wind((0.0, 0.0, -2.0), shielding=Shielding()), points, np.full(400, 0.4))
    assert push[-1, 2] > 0.5 * push[0, 2] and push[0, 2] < 0.0
