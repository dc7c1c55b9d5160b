"""Hair in locks comes to rest on a still body: audits end with the motion."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.levelset.bake import bake
from hairpipe.values import Mesh

from ...strand_scenes import even_ball
from .bundle import CORNERS, SCENE, build_bundle, shot

CENTRE, RADIUS = np.array([0.06, -0.012, -0.031]), 0.03


def still(time):
    return Mesh(CORNERS, np.array([[0, 1, 2]], np.int32), np.zeros((3, 3)))


@pytest.fixture(params=["free", "ball"])
def surfaces(request):
    """Nothing, or a ball that the bundle sinks onto."""
    if request.param == "free":
        return ()
    ball = bake(even_ball(CENTRE, RADIUS, 400), 0.004, 6.0)
    return ((ball, ball),)


AUDITS = replace(SCENE, locks=replace(SCENE.locks, audit=0.3))
"""Other locks are audited after every second frame, while hair moves."""


def motion_of(hair, states):
    """The largest displacement of a point in a frame [m], and the rms speed [m/s], in the last six of some frames."""
    points = np.array([hair.layout.axis(state.positions) for state in states[-6:]])
    velocities = np.array([hair.layout.axis(state.velocities) for state in states[-6:]])
    farthest = np.linalg.norm(np.diff(points, axis=0), axis=2).max()
    return farthest, np.sqrt((velocities**2).sum(axis=2).mean())


@pytest.mark.parametrize("model", ["network", "rod"])
def test_hair_in_locks_comes_to_rest(model, surfaces):
    """Within 3 s, or 5 s where a network falls freely. Guides change until then."""
    hair, frames = build_bundle(model), 126 if model == "network" and not surfaces else 72
    states = shot(hair, AUDITS, frames, driver=still, surfaces=surfaces)
    assert any(state.locks.compared.any() for state in states[:20] if state.locks)
    farthest, speed = motion_of(hair, states)
    assert farthest < 1e-5 and speed < 1e-4
    leaders = [state.locks.leaders for state in states[-6:]]
    assert (leaders[0] != np.arange(len(leaders[0]))).any()
    assert all(np.array_equal(now, leaders[0]) for now in leaders)
