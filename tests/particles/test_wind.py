"""The wind takes hold of all the fibre that particles stand for."""

import numpy as np
import pytest

from hairpipe.particles.settings import Fibre
from hairpipe.particles.step import Forces
from hairpipe.particles.wind import add_wind
from hairpipe.sim.air.cylinder import law_of, normal_drag
from hairpipe.sim.air.wind import Shielding, Wind


def forces_of(wind, points, masses, fibre=Fibre()):  # noqa: B008 (frozen)
    count = len(points)
    forces, down = Forces(np.zeros((count, 3)), np.zeros((count, 6))), np.tile([0.0, -1.0, 0.0], (count, 1))
    add_wind(wind, fibre, 0.02, masses, (points, down, np.zeros((count, 3))), 0.0, forces)
    return forces


def test_across_the_hair_it_pushes_as_on_a_cylinder_of_all_that_length():
    wind, masses = Wind((0.0, 0.0, -2.0)), np.array([1e-5, 3e-5])
    forces = forces_of(wind, np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), masses)
    length = masses / Fibre().line_density
    drag = length * normal_drag(law_of(wind, Fibre().diameter), 2.0)
    assert forces.push == pytest.approx(-2.0 * drag[:, None] * (0.0, 0.0, 1.0), abs=1e-15)
    assert forces.drag[:, [0, 5]] == pytest.approx(np.stack([drag, drag], axis=1))


def test_hair_keeps_the_wind_from_the_hair_behind_it():
    wind, points = Wind((0.0, 0.0, -2.0), shielding=Shielding()), np.zeros((400, 3))
    points[:, 2] = -np.linspace(0.0, 0.1, 400)
    push = -forces_of(wind, points, np.full(400, 5e-8)).push[:, 2]
    assert push[-1] < 0.5 * push[0]
