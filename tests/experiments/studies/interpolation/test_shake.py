"""Our bust in its head shake between two frames of 60 a second, in parts: as good as a level set of that very time."""

from pathlib import Path

import numpy as np
import pytest

from hairpipe.body.bust import build_bust
from hairpipe.body.posing import Playback, pose_at
from hairpipe.body.skinning import skin
from hairpipe.formats.bvh import recall_bvh
from hairpipe.geometry.collider import SdfSample
from hairpipe.graphs.experiments.studies.interpolation.clips import Clip, clip_table
from hairpipe.levelset.bake import bake
from hairpipe.levelset.bake_parts import bake_parts
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.levelset.sample import Interpolation

SHAKE = Path(__file__).resolve().parents[4] / "graphs" / "assets" / "shake.bvh"
VOXEL, HALF_WIDTH, SMALLEST = 0.004, 4.0, 0.18
FRAME = 1.0 / 60.0


@pytest.fixture(scope="module")
def bust():
    return build_bust()


@pytest.fixture(scope="module")
def poses(bust):
    """Half way through a turn of the head, at a key, half a frame later and at the next key."""
    clip, playback = recall_bvh(SHAKE), Playback(None, None, None, None, ())
    return [pose_at(bust.skeleton, clip, 1.5 + a * FRAME, 1.0, playback) for a in (0.0, 0.5, 1.0)]


@pytest.fixture(scope="module")
def parts(bust, poses):
    return [bake_parts(bust, pose, VOXEL, HALF_WIDTH, SMALLEST) for pose in poses]


@pytest.fixture(scope="module")
def whole(bust, poses):
    return [bake(skin(bust, pose), VOXEL, HALF_WIDTH) for pose in poses]


@pytest.mark.kernels
def test_parts_between_frames_are_off_by_no_more_than_samples_are(bust, poses, parts, whole):
    skins = [skin(bust, pose) for pose in poses]
    clip = Clip(dict(enumerate(skins)), dict(enumerate(whole)), dict(enumerate(parts)))
    table = clip_table(bust.mesh, clip, 2, 0.5 * FRAME)
    names = np.array(table["interpolation"])
    for column in ("error mean [mm]", "error max [mm]"):
        found, best = (table[column][(table["time [keys]"] == 0.5) & (names == n)] for n in ("parts", "baked then"))
        assert found < 1.2 * best


@pytest.mark.kernels
def test_parts_leave_no_hollow_in_the_body(bust, poses, parts, whole):
    points = skin(bust, poses[0]).points
    chance = np.random.default_rng(0)
    points = points + chance.uniform(-4.0, 4.0, points.shape) * VOXEL
    surfaces = (
        build_collider_field(whole[0], whole[0], FRAME, Interpolation.linear),
        build_collider_parts(parts[0], parts[0], FRAME),
    )
    probes = [SdfSample.blank(len(points)) for _ in surfaces]
    for surface, probe in zip(surfaces, probes, strict=True):
        surface.probe(points, 0.0, probe)
    inside = probes[0].distance < -VOXEL
    assert inside.mean() > 0.2 and (probes[1].distance[inside] < 0.0).all()
