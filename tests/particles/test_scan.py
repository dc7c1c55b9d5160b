"""The nodes: particles of a groom, frame by frame."""

import numpy as np
import pytest

from hairpipe.engine import Time
from hairpipe.laws.settings import Wind
from hairpipe.nodes.carry_strands import carry_strands
from hairpipe.nodes.sample_particles import sample_particles
from hairpipe.nodes.simulate_particles import prepare_particles, simulate_particles
from hairpipe.particles.settings import Interaction
from hairpipe.particles.skinning import find_influences
from hairpipe.values.strand_arrays import take

from .conftest import plate

DEFAULTS = {"sag": 0.1, "damping": 0.2, "gravity": 9.81, "interaction": Interaction(), "sag_free": None, "printed": ()}


def frames_of(particles, bodies, cuts=(), **settings):
    """Simulate a frame for every body, from the first on; return the clouds."""
    prepared, state, clouds = prepare_particles(particles, **DEFAULTS), None, []
    for frame, body in enumerate(bodies, 1):
        pair = (bodies[max(frame - 2, 0)], body)
        hair = simulate_particles(
            particles, pair, None, None, state, Time(frame, 24.0), cuts, prepared, interaction=Interaction(), **settings
        )
        clouds, state = [*clouds, hair.cloud], hair.state
    return clouds


def test_hair_follows_the_body_and_the_wind(curtain):
    particles = sample_particles(curtain, particles=300)
    still = frames_of(particles, 4 * [plate()])
    assert np.array_equal(still[0].points, particles.points)
    assert still[-1].points[:, 1].mean() < still[0].points[:, 1].mean()
    blown = frames_of(particles, 4 * [plate()], wind=Wind((3.0, 0.0, 0.0)))
    assert np.mean(blown[-1].points - still[-1].points, axis=0)[0] > 1e-3
    assert np.linalg.norm(blown[-1].directions, axis=1) == pytest.approx(1.0)


def test_over_a_cut_the_strands_that_they_carry_go_with_the_body_too(curtain):
    particles, there = sample_particles(curtain, particles=300), plate((5.0, 0.0, 0.0))
    groom = take(curtain, np.arange(0, 1000, 50))
    influences = find_influences(particles, groom)
    leapt, stayed = (
        [
            carry_strands(cloud, particles, groom, body, None, None, Time(frame, 24.0), influences)
            for frame, (cloud, body) in enumerate(zip(frames_of(particles, bodies, cuts=cuts), bodies, strict=True), 1)
        ]
        for bodies, cuts in ([2 * [plate()] + 2 * [there], (3,)], [4 * [plate()], ()])
    )
    for one, other in zip(leapt[2:], stayed[2:], strict=True):
        assert one.points == pytest.approx(other.points + np.array([5.0, 0.0, 0.0]), abs=1e-5)
        assert one.velocities == pytest.approx(other.velocities, abs=1e-3)
