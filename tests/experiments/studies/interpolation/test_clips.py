"""Keys and the frames between them, of a body that turns and of our bust."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from hairpipe.body.bust import build_bust
from hairpipe.body.posing import Playback, pose_at
from hairpipe.body.shapes import build_box
from hairpipe.body.skinning import skin
from hairpipe.engine import Frames
from hairpipe.errors import BadInput
from hairpipe.formats.bvh import recall_bvh
from hairpipe.geometry.collider import SdfSample
from hairpipe.graphs.experiments.studies.interpolation.bodies import parts_of, skin_at
from hairpipe.graphs.experiments.studies.interpolation.cases import CASES
from hairpipe.graphs.experiments.studies.interpolation.clips import Clip, clip_table
from hairpipe.levelset.bake import bake
from hairpipe.levelset.bake_parts import bake_parts
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.levelset.sample import Interpolation
from hairpipe.values import Table

COARSE, BAND = 0.1, 4.0
TURN = CASES[2]


@pytest.fixture(scope="module")
def clip():
    """A body that turns by 30 degrees over four steps, at any five frames."""
    skins = [skin_at(TURN, n / 4) for n in range(5)]
    surfaces = [bake(skin, COARSE, BAND) for skin in skins]
    shapes = [bake(solid.mesh(), COARSE, BAND) for solid in TURN.solids]
    parts = [parts_of(TURN, shapes, n / 4) for n in range(5)]

    def at(frames: Sequence[int]) -> Clip:
        kinds = [dict(zip(frames, values, strict=True)) for values in (skins, surfaces, parts)]
        return Clip(*(Frames(tuple(frames), kind.__getitem__) for kind in kinds))

    return at


def table_at(clip, frames: Sequence[int], dt: float) -> Table:
    return clip_table(skin_at(TURN, 0.0), clip(frames), 2, dt)


def test_frames_that_are_omitted_are_not_requested(clip):
    full, sparse = table_at(clip, range(1, 6), 1 / 24), table_at(clip, range(1, 11, 2), 1 / 48)
    assert set(full["time [keys]"]) == {0.0, 0.5, 1.0}
    for name in full.names:
        np.testing.assert_array_equal(full[name], sparse[name])


def test_time_between_keys_is_that_of_the_frame(clip):
    assert set(table_at(clip, (1, 2, 5, 8, 9), 1 / 24)["time [keys]"]) == {0.0, 0.25, 0.75, 1.0}


def test_a_body_of_another_rest_is_refused(clip):
    with pytest.raises(BadInput, match=r"in\.body: the triangles are not those of in\.rest"):
        clip_table(build_box((1.0, 1.0, 1.0), (0.0, 0.0, 0.0)), clip(range(5)), 2, 1 / 24)


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
