"""Particles stay as near to their roots as hair is long, and it is said where they would not."""

import warnings

import numpy as np
import pytest

from hairpipe.laws.settings import Wind
from hairpipe.particles.model import LOAD

LENGTH = 0.2
"""Of the hair of the curtain [m]."""


def farthest(hair):
    """Distance of particles from their roots over that at rest along the hair, which is straight."""
    deep, particles = hair.prepared.model.deep, hair.particles
    roots = particles.hair.points[particles.hair.offsets[:-1]][particles.strands[deep:]]
    return np.linalg.norm(hair.state.points[deep:] - roots, axis=1)


def test_wind_throws_no_particle_farther_than_hair_stretches(shot):
    hair = shot(wind=Wind((0.0, 0.0, -30.0)))
    with pytest.warns(UserWarning, match=r"are too far from their roots at frame 1, the farthest .* m, over .* m, on"):
        hair.run(4)
    assert farthest(hair).max() <= (LENGTH + hair.particles.reach) * (1.0 + LOAD * hair.settings.sag / 2.0) + 1e-9
    assert hair.pace < 40.0


def test_hair_that_hangs_and_swings_is_within_reach(shot):
    hair = shot()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hair.run(6, kick=lambda frame: np.array([2.0, 0.0, 0.0]) * (frame == 0))
    assert farthest(hair).max() > LENGTH


def test_wind_that_tears_hair_from_its_roots_diverges_with_numbers(shot):
    with pytest.raises(ArithmeticError, match=r"^diverged: \d+ of \d+ particles .* the farthest .*e\+\d+ m, over"):
        shot(wind=Wind((0.0, 0.0, 1e8))).run(2)


def test_wind_that_no_solve_can_hold_diverges_with_numbers(shot):
    """It left hair where it was, at speed 0."""
    with pytest.raises(ArithmeticError, match=r"^diverged: the force of air on a particle is .*e\+\d\d N"):
        shot(wind=Wind((0.0, 0.0, 1e30))).run(1)
