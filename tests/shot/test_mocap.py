"""Real motion, in its most violent second, at three frame rates: nothing explodes, nothing stretches."""

from itertools import pairwise

import numpy as np
import pytest

from hairpipe.body.bust import build_bust
from hairpipe.engine import Time
from hairpipe.laws.settings import StrainLimit
from hairpipe.nodes.grow_groom import grow_groom
from hairpipe.nodes.load_motion import load_motion
from hairpipe.nodes.pose_body import pose_body
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import advance_frame, start
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

VIOLENT = {"cmu_05_06": 3.0, "cmu_49_08": 4.0, "cmu_61_12_scaled": 6.7, "fair1_dab": 4.7, "rokoko_jesse_dance": 8.1}
"""Where in each clip the head turns fastest [s]."""


@pytest.fixture(scope="module")
def bust():
    return build_bust()


@pytest.fixture(scope="module")
def hair(bust):
    return build_hair(grow_groom(bust, strands=16, segments=20), Material(), "network")


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("fps", [6.0, 24.0, 60.0])
@pytest.mark.parametrize("clip", VIOLENT)
def test_hair_follows_any_motion_at_any_frame_rate(shared, bust, hair, clip, fps):
    file = shared / "mocap" / f"{clip}.bvh"
    frames = range(1001, 1001 + round(fps))
    poses = (load_motion(bust, Time(frame, fps), (), file=file, start=VIOLENT[clip]) for frame in frames)
    bodies = [pose_body(bust, pose) for pose in poses]
    scene = Scene(strain=StrainLimit())
    state = start(hair, bodies[0], scene)
    rest = np.linalg.norm(np.diff(hair.groom.points.reshape(16, 21, 3), axis=1), axis=2)
    for before, after in pairwise(bodies):
        state = advance_frame(hair, state, (before, after), (), 1 / fps, scene)
        axis = hair.layout.axis(state.positions).reshape(16, 21, 3)
        assert np.isfinite(axis).all()
        stretch = np.linalg.norm(np.diff(axis, axis=1), axis=2) / rest
        assert stretch.max() <= 1 + scene.strain.tolerance + 1e-9
        assert np.abs(state.velocities).max() < 80.0
