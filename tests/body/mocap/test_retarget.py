import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.body.performer import place_joints
from hairpipe.body.preparation import transform
from hairpipe.body.retarget import ADULT_LEG, build_retarget
from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import invert
from hairpipe.values import Body, Mesh, Skeleton
from hairpipe.values.body import Clip

ZERO = np.zeros(1)


def retarget(skeleton, clip, **settings):
    return build_retarget(skeleton, clip, **{"up": None, "reference": None, "unit": None, "joints": ()} | settings)


def scaled(skeleton: Skeleton, factor: float) -> Skeleton:
    body = Body(Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32)), skeleton, np.zeros((0, 1)), np.zeros((0, 1)))
    return transform(body, factor * np.eye(3)).skeleton


def only(skeleton: Skeleton, *names: str) -> Skeleton:
    """A chain of some joints."""
    keep = [skeleton.names.index(name) for name in names]
    parents = np.arange(-1, len(keep) - 1, dtype=np.int32)
    return Skeleton(names, parents, skeleton.rest[keep], skeleton.tips[keep])


def test_a_performer_at_rest_leaves_the_body_at_rest(skeleton, make_clip):
    pose = retarget(skeleton, make_clip(3)).transforms(make_clip(3), ZERO)[0]
    np.testing.assert_allclose(pose, skeleton.rest, atol=1e-12)


@pytest.mark.parametrize("reference", ["zero", "first"])
def test_a_body_built_like_the_performer_moves_like_it(skeleton, make_clip, reference):
    clip = make_clip(9, seed=2)
    clip.values[0, 3:] = 0.0  # the first frame is the body's rest pose too
    frames = np.array([0.0, 3.5, 8.0])
    pose = retarget(skeleton, clip, reference=reference).transforms(clip, frames)
    placed = place_joints(clip, frames)
    np.testing.assert_allclose(pose[..., :3, :3], placed.rotations, atol=1e-9)
    moved = placed.positions - placed.positions[:, :1] + pose[:, :1, :3, 3]
    np.testing.assert_allclose(pose[..., :3, 3], moved, atol=1e-9)


def test_a_clip_turned_as_a_whole_turns_the_body(skeleton, make_clip):
    """The turn is put in front of the root's channels, and its positions are turned: the reference pose stays."""
    clip = make_clip(6, seed=3)
    turn = Rotation.from_euler("y", 70.0, degrees=True)
    root = turn * Rotation.from_euler("ZXY", clip.values[:, 3:6], degrees=True)
    values = clip.values.copy()
    values[:, :3] = turn.apply(values[:, :3])
    values[:, 3:6] = root.as_euler("ZXY", degrees=True)
    frames = np.arange(6.0)
    plain = retarget(skeleton, clip).transforms(clip, frames)
    turned_clip = replace(clip, values=values)
    turned = retarget(skeleton, turned_clip).transforms(turned_clip, frames)
    whole = np.eye(4)
    whole[:3, :3] = turn.as_matrix()
    np.testing.assert_allclose(turned, whole @ plain, atol=1e-9)


def test_bones_keep_their_length_whoever_performs(skeleton, make_clip):
    body = scaled(skeleton, 1.3)
    clip = make_clip(5, seed=4)
    places = retarget(body, clip).transforms(clip, np.arange(5.0))[..., :3, 3]
    bones = np.linalg.norm(places[:, 1:] - places[:, body.parents[1:]], axis=-1)
    rest = body.rest[:, :3, 3]
    np.testing.assert_allclose(bones, np.tile(np.linalg.norm(rest[1:] - rest[body.parents[1:]], axis=1), (5, 1)))


def test_steps_grow_with_the_legs(skeleton, make_clip):
    clip = make_clip(2)
    clip.values[1, :3] += (0.5, -0.1, 0.2)
    for factor in (0.5, 1.0, 2.0):
        places = retarget(scaled(skeleton, factor), clip).transforms(clip, np.array([0.0, 1.0]))[..., :3, 3]
        np.testing.assert_allclose(
            places[1] - places[0], np.tile(factor * np.array([0.5, -0.1, 0.2]), (16, 1)), atol=1e-9
        )
        assert places[0, :, 1].min() == pytest.approx(factor * 0.05)  # ankles over the floor as at rest


def test_a_unit_that_is_given_rules(skeleton, make_clip):
    clip = make_clip(2)
    clip.values[1, 0] += 1.0
    places = retarget(skeleton, clip, unit=0.01).transforms(clip, np.array([0.0, 1.0]))[:, 0, :3, 3]
    np.testing.assert_allclose(places[1] - places[0], [0.01, 0.0, 0.0], atol=1e-12)


def test_unmatched_joints_follow_their_parents(skeleton, make_clip):
    clip = make_clip(3, seed=5)
    names = tuple("Tail" if name == "RightHand" else name for name in skeleton.names)
    body = replace(skeleton, names=names)
    pose = retarget(body, clip).transforms(clip, np.array([1.0]))[0]
    hand, elbow = names.index("Tail"), names.index("RightForeArm")
    local = invert(pose[elbow]) @ pose[hand]
    np.testing.assert_allclose(local, invert(body.rest[elbow]) @ body.rest[hand], atol=1e-12)


def test_joints_can_be_given_in_pairs(skeleton, make_clip):
    clip = make_clip(3, seed=6)
    body = replace(skeleton, names=tuple("Noggin" if name == "Head" else name for name in skeleton.names))
    pose = retarget(body, clip, joints=(("Noggin", "Head"),)).transforms(clip, np.array([2.0]))
    np.testing.assert_allclose(pose, retarget(skeleton, clip).transforms(clip, np.array([2.0])), atol=1e-12)


@pytest.mark.parametrize(
    ("pair", "message"), [(("Haed", "Head"), "body.*Haed.*Head"), (("Head", "Skull"), "clip.*Skull")]
)
def test_a_joint_that_does_not_exist_is_named(skeleton, make_clip, pair, message):
    with pytest.raises(BadInput, match=message):
        retarget(skeleton, make_clip(2), joints=(pair,))


def test_strangers_are_refused(skeleton, make_clip):
    stranger = replace(make_clip(2), names=tuple(f"x{i}" for i in range(16)))
    with pytest.raises(BadInput, match="no joint of the body matches"):
        retarget(skeleton, stranger)


@pytest.mark.parametrize("name", ["head", "box"])
def test_a_body_of_one_joint_follows_the_head(skeleton, make_clip, name):
    rest = skeleton.rest[skeleton.names.index("Head")][None]
    single = Skeleton((name,), np.array([-1], np.int32), rest, rest[:, :3, 3])
    clip = make_clip(4, seed=7)
    frames = np.arange(4.0)
    pose = retarget(single, clip).transforms(clip, frames)[:, 0]
    placed, head = place_joints(clip, frames), clip.names.index("Head")
    np.testing.assert_allclose(pose[:, :3, :3], placed.rotations[:, head], atol=1e-9)
    steps = np.diff(placed.positions[:, head], axis=0) * ADULT_LEG / 0.8
    np.testing.assert_allclose(np.diff(pose[:, :3, 3], axis=0), steps, atol=1e-9)


def test_unknown_unit_of_a_clip_is_reported(skeleton, make_clip):
    single = only(skeleton, "Head")
    clip = make_clip(2)
    clip = replace(clip, names=tuple(name.replace("Leg", "Wheel") for name in clip.names))
    with pytest.warns(UserWarning, match="unit"):
        assert retarget(single, clip).scale == 1.0
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message="cannot tell")
        assert retarget(single, clip, unit=0.01).scale == 0.01
        retarget(single, make_clip(2))


def test_a_bust_rests_where_it_stands_while_the_performer_does(skeleton, make_clip):
    bust = only(skeleton, "Spine", "Neck", "Head")
    np.testing.assert_allclose(retarget(bust, make_clip(2)).transforms(make_clip(2), ZERO)[0], bust.rest, atol=1e-12)


def test_a_clip_without_legs_is_scaled_from_root_to_head(skeleton):
    bones = only(skeleton, "Spine", "Neck", "Head").rest[:, :3, 3]
    offsets = np.concatenate([bones[:1], np.diff(bones, axis=0)])
    values = np.array([bones[0], bones[0] + (0.3, 0.0, 0.0)])
    channels = (("Xposition", "Yposition", "Zposition"), (), ())
    parents, ends = np.array([-1, 0, 1], np.int32), np.full((3, 3), np.nan)
    clip = Clip(("chest", "neck", "head"), parents, offsets, ends, channels, values, 0.1)
    bust = scaled(only(skeleton, "Spine", "Neck", "Head"), 2.0)
    places = retarget(bust, clip).transforms(clip, np.array([0.0, 1.0]))[:, 0, :3, 3]
    assert places[1, 0] - places[0, 0] == pytest.approx(2.0 * 0.3)
