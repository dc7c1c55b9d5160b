"""Hair that has come to rest on a body reports the velocity of its motion."""

import numpy as np
import pytest

from hairpipe.body.shapes import build_box
from hairpipe.levelset.bake.whole import bake
from hairpipe.sim.build import bodies_of
from hairpipe.sim.hair_model import build_hair
from hairpipe.sim.material import Material
from hairpipe.sim.settings import BodyContact, Scene
from hairpipe.sim.simulate import advance_frame, start, strands_of

from ..conftest import groom_of

FPS, FRAMES = 24.0, 72
BOX = bake(build_box((0.03, 0.03, 0.05), (0.05, -0.025, 0.0)), 0.004, 4.0)


@pytest.mark.parametrize("model", ["network", "rod"])
def test_hair_at_rest_reports_the_velocity_of_its_motion(model):
    scene = Scene(contact=BodyContact(thickness=0.5e-3), strain=None)
    hair = build_hair(groom_of([np.linspace(0.0, 0.1, 13)[:, None] * [1.0, 0.0, 0.0]]), Material(), model)
    bodies = bodies_of([(BOX, BOX)], [], scene.contact, 1.0 / FPS)
    state = start(hair, None, scene)
    frames = []
    for frame in range(FRAMES):
        state = advance_frame(hair, state, (None, None), bodies, 1.0 / FPS, scene, frame / FPS)
        frames.append(strands_of(hair, state))
    before, now = frames[-2:]
    assert np.abs(now.velocities - FPS * (now.points - before.points)).max() < 1e-5
    assert np.abs(now.points - before.points).max() < 1e-6
    assert now.points[-1, 1] < -0.01  # It hangs over the edge.
