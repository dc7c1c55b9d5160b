"""Bodies and their motion, loaded from files."""

from pathlib import Path

import numpy as np
import pytest

from hairpipe.body.bust import build_skeleton
from hairpipe.body.scalp import Scalp
from hairpipe.engine import Time
from hairpipe.nodes.load_body import load_body
from hairpipe.nodes.load_motion import load_motion
from hairpipe.values import Body, Mesh


def test_an_obj_file_becomes_a_body_of_one_joint(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 10 0 0\nv 0 0 10\nv 9 9 9\nf 1 2 3\n")
    body = load_body(file=tmp_path / "a.obj", unit=0.1, up="z", joint="skull")
    assert body.skeleton.names == ("skull",)
    np.testing.assert_allclose(body.mesh.points, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], atol=1e-12)


def test_a_usd_file_without_a_skeleton_becomes_a_body_of_one_joint(tmp_path):
    (tmp_path / "a.usda").write_text(
        """#usda 1.0
        (metersPerUnit = 1)
        def Mesh "triangle"
        {
            point3f[] points = [(0, 1, 0), (1, 1, 0), (1, 2, 0)]
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
        }
        """
    )
    body = load_body(file=tmp_path / "a.usda", joint="skull")
    assert body.skeleton.names == ("skull",)
    np.testing.assert_allclose(body.skeleton.rest[0, :3, 3], [2 / 3, 4 / 3, 0], atol=1e-7)


def test_the_makehuman_body_has_a_rig_and_a_scalp(shared):
    folder = shared / "body_makehuman"
    rig = {"skeleton": folder / "default.mhskel", "weights": folder / "default_weights.mhw"}
    body = load_body(file=folder / "base.obj", group="body", unit=0.1, scalp=Scalp(), **rig)
    assert len(body.mesh.points) == 13380 and len(body.skeleton.names) == 163 and body.weights.shape[1] == 9
    assert np.ptp(body.mesh.points[:, 1]) == pytest.approx(1.666, abs=0.001)
    np.testing.assert_allclose(body.weights.sum(axis=1), 1.0)
    assert 200 < np.count_nonzero(body.maps["scalp"] > 0.5) < 800


def test_the_sintel_bust_is_in_metres(shared):
    body = load_body(file=shared / "sintel" / "sintel.obj")
    assert (len(body.mesh.points), len(body.mesh.triangles)) == (3046, 5952)
    assert body.mesh.points[:, 1].max() == pytest.approx(1.655, abs=0.001)
    assert body.skeleton.names == ("head",)


SHAKE = Path(__file__).resolve().parents[2] / "graphs" / "assets" / "shake.bvh"


@pytest.fixture
def bust() -> Body:
    """The skeleton of our bust without its skin."""
    return Body(
        Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32)), build_skeleton(), np.zeros((0, 1)), np.zeros((0, 1))
    )


def yaw(pose) -> float:
    return float(np.degrees(np.arctan2(pose.transforms[-1, 0, 2], pose.transforms[-1, 2, 2])))


def test_the_clip_starts_at_the_first_frame_of_a_shot(bust):
    pose = load_motion(bust, Time(1001, 24.0), (), file=SHAKE)
    np.testing.assert_allclose(pose.transforms, bust.skeleton.rest, atol=1e-9)
    np.testing.assert_array_equal(pose.rates, 0.0)


@pytest.mark.parametrize(
    ("frame", "fps", "settings"),
    [
        (1021, 24.0, {}),
        (1051, 60.0, {}),
        (21, 24.0, {"at": 1}),
        (1001, 24.0, {"start": 20.0 / 24.0}),
        (1041, 24.0, {"speed": 0.5}),
        (1001 + 2000, 2400.0, {}),
    ],
)
def test_frame_rate_start_and_speed_all_lead_to_the_same_instant(bust, frame, fps, settings):
    pose = load_motion(bust, Time(frame, fps), (), file=SHAKE, **settings)
    same = load_motion(bust, Time(1021, 24.0), (), file=SHAKE)
    np.testing.assert_allclose(pose.transforms, same.transforms, atol=1e-9)
    np.testing.assert_allclose(pose.rates, same.rates * settings.get("speed", 1.0), atol=1e-9)
    assert abs(yaw(pose)) > 20.0


@pytest.fixture(scope="module")
def person(shared) -> Body:
    folder = shared / "body_makehuman"
    rig = {"skeleton": folder / "default.mhskel", "weights": folder / "default_weights.mhw"}
    return load_body(file=folder / "base.obj", group="body", unit=0.1, **rig)


# Seconds at which the performer stands on both feet, seen in pictures of the clips.
UPRIGHT = {"cmu_05_06": 6.0, "cmu_61_12_scaled": 0.1, "fair1_dab": 0.1, "rokoko_jesse_dance": 0.1}


@pytest.mark.filterwarnings("ignore:the clip's first frame", "ignore:where the clip's feet")
@pytest.mark.parametrize("name", UPRIGHT)
def test_a_person_stands_where_the_performer_stands(shared, person, name):
    from hairpipe.body.skinning import skin

    pose = load_motion(person, Time(1001, 24.0), (), file=shared / "mocap" / f"{name}.bvh", start=UPRIGHT[name])
    up = {
        joint: pose.transforms[person.skeleton.names.index(joint), 1, 3]
        for joint in ("head", "root", "foot.L", "foot.R")
    }
    assert up["head"] - up["root"] > 0.5
    assert up["root"] - max(up["foot.L"], up["foot.R"]) > 0.5
    sole, floor = skin(person, pose).points[:, 1].min(), person.mesh.points[:, 1].min()
    assert sole == pytest.approx(floor, abs=0.08)


@pytest.mark.parametrize("name", ["bust", "person"])
def test_our_own_clip_fits_every_body(request, name):
    body = request.getfixturevalue(name)
    head = body.skeleton.names.index("head")
    rest, pose = body.skeleton.rest[head], load_motion(body, Time(1021, 24.0), (), file=SHAKE).transforms[head]
    turn = pose[:3, :3] @ rest[:3, :3].T
    assert 30.0 < np.degrees(np.arccos((np.trace(turn) - 1.0) / 2.0)) < 60.0
    assert np.linalg.norm(pose[:3, 3] - rest[:3, 3]) < 0.05


@pytest.mark.parametrize("settle", [0.2, 1.0])
def test_the_body_comes_smoothly_from_rest_to_the_pose_that_the_shot_begins_with(bust, settle):
    """Its rates are those of its places, it begins at rest, and comes with pose and velocity of the clip."""
    fps = 240.0
    count = round(settle * fps)
    kwargs = {"file": SHAKE, "start": 20.0 / 24.0}
    poses = [load_motion(bust, Time(1001 - n, fps), (), settle=settle, **kwargs) for n in (count, count + 5, 1, 0)]
    clip = load_motion(bust, Time(1001, fps), (), **kwargs)
    for pose in poses[:2]:
        np.testing.assert_allclose(pose.transforms, bust.skeleton.rest, atol=1e-12)
        assert np.abs(pose.rates).max() < 0.01
    np.testing.assert_array_equal(poses[3].transforms, clip.transforms)
    assert np.abs(clip.rates).max() > 0.5
    change = (poses[3].transforms - poses[2].transforms) * fps
    np.testing.assert_allclose(change, 0.5 * (poses[2].rates + clip.rates), atol=0.05)
    middle = [load_motion(bust, Time(1001 - count // 2 - n, fps), (), settle=settle, **kwargs) for n in (-1, 0, 1)]
    change = (middle[0].transforms - middle[2].transforms) * fps / 2
    np.testing.assert_allclose(middle[1].rates, change, atol=0.05)
    turns = middle[1].transforms[:, :3, :3]
    np.testing.assert_allclose(turns @ np.swapaxes(turns, 1, 2), np.tile(np.eye(3), (len(turns), 1, 1)), atol=1e-12)
