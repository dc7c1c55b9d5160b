"""Hair at rest on a body, and on other hair."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from hairpipe.body.shapes import build_box
from hairpipe.graphs.experiments.studies.contact.rub import ends_at, lay_crossed
from hairpipe.laws.settings import BodyContact, Collisions, Thickness
from hairpipe.levelset.bake import bake
from hairpipe.shot.build import bodies_of
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start, strands_of
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

from ..strand_scenes import groom_of

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


@pytest.mark.kernels
def test_soft_heavy_hair_comes_to_rest_on_hair():
    """Its weight strains it by less than the strain limit, which may not draw it through the hair below."""
    collisions = Collisions(Thickness(5e-4))
    scene = Scene(collisions=collisions)
    soft = Material(young=2e6, density=1e4, softening=1.0)
    hair = build_hair(lay_crossed(1.5e-3, 25, 0.0, 0.015), soft, "rod")
    still = CubicHermiteSpline([0.0, 10.0], np.zeros((2, 3)), np.zeros((2, 3)))
    ends = ends_at(still, 0.0)
    state = start(hair, ends, scene)
    for frame in range(36):
        state = advance_frame(hair, state, (ends, ends), (), 1.0 / FPS, scene, frame / FPS)
    tip = hair.layout.axis(state.positions)[-1]
    assert tip[1] > -0.02  # Half of it hangs down from the hair below; without that it would hang from its root.
