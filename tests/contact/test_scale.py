"""A scene four times as large, in twice the time, has the same motion: contact and stiction follow the scene."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.body.shapes import build_box
from hairpipe.contact.contact_points import USUAL, scale_of
from hairpipe.laws.settings import Air, BodyContact, Collisions, Drag, Force, StepControl, Stiction, Thickness
from hairpipe.levelset.bake import bake
from hairpipe.shot.build import bodies_of
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start, strands_of
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

from ..strand_scenes import groom_of

LARGER, SLOWER, DENSER = 4.0, 2.0, 8.0
FRAMES, FPS = 16, 24.0
EXACT = 1e-9
"""Difference of positions, over the length of a strand."""


def shoot(
    model: str, thickness: float, *, size: float = 1.0, time: float = 1.0, dense: float = 1.0, stick: bool = True
):
    """Let a bundle of hairs fall on the edge of a box; points at every frame, (frames, points, 3)."""
    along = np.linspace(0.0, 0.06, 9)[:, None] * [1.0, 0.1, 0.05]
    roots = [[0.0, 0.02 + 0.6e-3 * k, 0.3e-3 * (k % 3)] for k in range(6)]
    groom = groom_of([size * (root + along) for root in roots])
    solid = build_box((0.03 * size, 0.02 * size, 0.05 * size), (0.05 * size, 0.0, 0.0))
    box = bake(solid, 0.004 * size, 4.0)
    scene = Scene(
        air=Air(Drag(8.0 / time)),
        contact=BodyContact(thickness=thickness * size),
        steps=StepControl(longest=time / 240, root=0.01 * size, travel=0.02 * size),
        collisions=Collisions(Thickness(0.4e-3 * size), stiffness=0.1 * size**2 * dense),
        stiction=Stiction(reach=0.5e-3 * size, release=1.5e-3 * size, force=Force(2e-5 * size**3 * dense))
        if stick
        else None,
    )
    usual = Material()
    wide, stiff = usual.diameter * size, usual.young * size * dense
    hair = build_hair(groom, replace(usual, diameter=wide, young=stiff, density=usual.density * dense), model)
    frame_dt = time / FPS
    bodies = bodies_of([(box, box)], [], scene.contact, frame_dt)
    state = start(hair, None, scene)
    shown = []
    for frame in range(FRAMES):
        state = advance_frame(hair, state, (None, None), bodies, frame_dt, scene, frame * frame_dt)
        shown.append(strands_of(hair, state).points.astype(float))
    return np.array(shown)


@pytest.mark.parametrize("model", ["network", "rod"])
@pytest.mark.parametrize("thickness", [1e-3, 0.0])
def test_a_larger_scene_has_the_same_motion(model, thickness):
    usual = shoot(model, thickness)
    larger = shoot(model, thickness, size=LARGER, time=SLOWER, dense=DENSER)
    assert np.abs(larger / LARGER - usual).max() < EXACT * 0.06
    assert np.ptp(usual[:, 8::9, 1]) > 5e-3  # Tips have fallen,
    assert np.abs(shoot(model, thickness, stick=False)[-1] - usual[-1]).max() > 1e-4  # and hair sticks to hair.


def test_the_default_scene_has_the_usual_scale():
    assert scale_of(BodyContact().thickness, BodyContact().thickness, Scene().gravity) == USUAL
    assert scale_of(1e-3, 1e-3, 0.0) == USUAL
    assert scale_of(4e-3, 1e-3, 9.81) == (4.0, 2.0, 2.0)
    assert scale_of(1e-3, 1e-3, 4 * 9.81) == (1.0, 0.5, 2.0)
