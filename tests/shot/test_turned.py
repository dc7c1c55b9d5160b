"""A scene that is turned, or far away, is the same scene: nothing knows the axes or the origin of the world."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.geometry.curl import Helix, wound
from hairpipe.laws.settings import StepControl, StrainLimit, Wind
from hairpipe.shot import build, simulate
from hairpipe.shot.settings import Scene
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Mesh

SCENE = Scene(strain=StrainLimit(), steps=StepControl(longest=1 / 960))
LENGTH, FRAMES = 0.15, 1
SPIN = Rotation.from_rotvec([0.0, 0.0, 0.15])


@pytest.fixture
def seen(scene, straight, monkeypatch):
    """Give the hair of a plate that spins, at its last frame, as one sees it who was turned and moved along."""

    def run(turn, shift, precision, model="network"):
        for module in (simulate, build):
            monkeypatch.setattr(module, "gravity_of", lambda scene: turn.apply([0.0, -scene.gravity, 0.0]))
        root = straight(0.1, 1, [1, 0, 0])[0]
        strands = [straight(LENGTH, 12, [1, 0.3, 0]), straight(LENGTH, 12, [0.2, -1, 0.1])]
        if model == "network":
            strands.append(root + wound(Helix(0.02, 0.03), LENGTH, 12) @ [[0, 0, 1], [1, 0, 0], [0, 1, 0]])
        shot = scene(strands)
        groom, body = shot.hair.groom, shot.body
        frames = groom.root_frames.copy()
        frames[:, :, :3] = turn.as_matrix() @ frames[:, :, :3]
        frames[:, :, 3] = turn.apply(frames[:, :, 3]) + shift
        groom = replace(groom, points=turn.apply(groom.points) + shift, root_frames=frames)
        hair = build_hair(groom, Material(), model, precision=precision)
        how = replace(SCENE, wind=Wind(tuple(turn.apply([0.0, 0.0, 2.0]).tolist())))

        def plate(frame):
            return Mesh(np.ascontiguousarray(turn.apply((SPIN**frame).apply(body.points)) + shift), body.triangles)

        state = simulate.start(hair, plate(0), how)
        for frame in range(FRAMES):
            drivers = plate(frame), plate(frame + 1)
            state = simulate.advance_frame(hair, state, drivers, [], 1 / 24, how, frame / 24)
        shown = simulate.strands_of(hair, state)
        return turn.inv().apply(shown.points - shift), turn.inv().apply(shown.velocities), shown.offsets

    return run


@pytest.mark.parametrize(("precision", "rounding", "turns"), [("double", 1e-8, 2), ("single", 2e-3, 1)])
def test_a_turned_scene_is_the_turned_result(seen, precision, rounding, turns):
    points, velocities, _ = seen(Rotation.identity(), np.zeros(3), precision)
    for seed in range(turns):
        turned = seen(Rotation.random(random_state=seed), np.zeros(3), precision)
        np.testing.assert_allclose(turned[0], points, atol=rounding * LENGTH)
        np.testing.assert_allclose(turned[1], velocities, atol=100 * rounding * LENGTH)


@pytest.mark.parametrize(("precision", "rounding"), [("double", 1e-8), ("single", 2e-3)])
@pytest.mark.parametrize("far", [1e3, 1e4])
def test_a_scene_far_from_the_origin_is_the_same_scene(seen, precision, rounding, far):
    """The plate is in single precision 0.06 and 1 mm off there, and hair would be stretched by as much a segment."""
    shift = far * np.array([0.6, -0.48, 0.64])
    near, there = (seen(Rotation.identity(), way, precision) for way in (np.zeros(3), shift))
    np.testing.assert_allclose(there[0], near[0], atol=rounding * LENGTH)
    np.testing.assert_allclose(there[1], near[1], atol=100 * rounding * LENGTH)
    inside = np.delete(np.arange(len(near[0]) - 1), near[2][1:-1] - 1)
    one, other = (np.linalg.norm(np.diff(points, axis=0), axis=1)[inside] for points in (near[0], there[0]))
    np.testing.assert_allclose(other, one, rtol=1e-5)
