"""What a clip and a body have in common is followed, and all else is named: joints, limbs, axes, channels."""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial.transform import Rotation

from hairpipe.app.cli.entry import commands
from hairpipe.body.bust import build_skeleton
from hairpipe.body.performer import place_joints
from hairpipe.body.posing import Playback, pose_at
from hairpipe.body.preparation import transform
from hairpipe.body.retarget import (
    ADULT_LEG,
    align_parts,
    build_retarget,
    find_heading,
    find_reference,
    standing_direction,
)
from hairpipe.body.roles import Role, find_roles
from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import invert
from hairpipe.graphs.assets.bvh_writing import write_bvh
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


Y_TO_Z = Rotation.from_euler("x", 90.0, degrees=True).as_matrix()
ASF = {"Hips": "root", "Spine": "thorax", "Neck": "lowerneck", "Head": "head"}
BONES = {"Arm": "humerus", "ForeArm": "radius", "Hand": "hand", "UpLeg": "femur", "Leg": "tibia", "Foot": "foot"}
ASF |= {side + bone: side[0].lower() + name for side in ("Left", "Right") for bone, name in BONES.items()}
VRM = {"Hips": "J_Bip_C_Hips", "Spine": "J_Bip_C_Chest", "Neck": "J_Bip_C_Neck", "Head": "J_Bip_C_Head"}
BONES = {
    "Arm": "UpperArm",
    "ForeArm": "LowerArm",
    "Hand": "Hand",
    "UpLeg": "UpperLeg",
    "Leg": "LowerLeg",
    "Foot": "Foot",
}
VRM |= {side + bone: f"J_Bip_{side[0]}_{name}" for side in ("Left", "Right") for bone, name in BONES.items()}


def warned(skeleton: Skeleton, clip: Clip, **settings):
    """The motion of all joints in all frames, and what was warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = build_retarget(skeleton, clip, **{"up": None, "reference": None, "unit": None, "joints": ()} | settings)
    return found.transforms(clip, np.arange(float(len(clip.values)))), [str(warning.message) for warning in caught]


def renamed(clip: Clip, names) -> Clip:
    return replace(clip, names=tuple(names(name) for name in clip.names))


def in_axes(clip: Clip, matrix: np.ndarray) -> Clip:
    """The same motion in a file with other axes: rotations are about the new ones."""
    channels, values, column = [], clip.values.copy(), 0
    for names in clip.channels:
        places = [column + i for i, name in enumerate(names) if name.endswith("position")]
        turns = [column + i for i, name in enumerate(names) if name.endswith("rotation")]
        if places:
            values[:, places] = values[:, places] @ matrix.T
        order = "".join(names[i - column][0] for i in turns)
        matrices = matrix @ Rotation.from_euler(order, values[:, turns], degrees=True).as_matrix() @ matrix.T
        values[:, turns] = Rotation.from_matrix(matrices).as_euler("XYZ", degrees=True)
        channels.append((*names[: len(places)], "Xrotation", "Yrotation", "Zrotation"))
        column += len(names)
    turned = {"offsets": clip.offsets @ matrix.T, "ends": clip.ends @ matrix.T}
    return replace(clip, channels=tuple(channels), values=values, **turned)


@pytest.mark.parametrize("names", [ASF, VRM], ids=["asf", "vrm"])
def test_names_of_other_programs_give_the_same_motion(skeleton, make_clip, names):
    clip = make_clip(5, seed=2)
    plain, _ = warned(skeleton, clip)
    other, reported = warned(skeleton, renamed(clip, names.__getitem__))
    assert plain.tobytes() == other.tobytes() and reported == []


@pytest.mark.parametrize(
    "names",
    ["mixamorig_{}", "CC_Base_{}", "{}_jnt", "Quick_Rig_{}_Bone", "mixamorig7:{}", "Robot_{}", "Rig|Someone_{}", "m{}"],
)
def test_the_name_of_a_character_does_not_matter(skeleton, make_clip, names):
    clip = make_clip(5, seed=2)
    other, reported = warned(skeleton, renamed(clip, names.format))
    assert warned(skeleton, clip)[0].tobytes() == other.tobytes() and reported == []


@pytest.mark.parametrize("left_out", [(), ("Head",), ("Head", "Neck"), ("LeftFoot", "Head")])
def test_z_up_is_inferred_from_the_trunk(skeleton, make_clip, left_out):
    clip = renamed(make_clip(5, seed=2), lambda name: "x" + name if name in left_out else name)
    plain, _ = warned(skeleton, clip, up="y", reference="zero")
    other, reported = warned(skeleton, in_axes(clip, Y_TO_Z), reference="zero")
    assert other == pytest.approx(plain, abs=1e-9)
    assert not any("points up" in message for message in reported)


def stood_along_z(clip: Clip) -> Clip:
    """The motion of a clip in a world with Z up, on the skeleton that is drawn with Y up."""
    values = clip.values.copy()
    order = "".join(name[0] for name in clip.channels[0][3:])
    turns = Y_TO_Z @ Rotation.from_euler(order, values[:, 3:6], degrees=True).as_matrix()
    values[:, :3] = values[:, :3] @ Y_TO_Z.T
    values[:, 3:6] = Rotation.from_matrix(turns).as_euler(order, degrees=True)
    return replace(clip, values=values)


def test_a_rest_pose_along_another_axis_than_the_motion_is_warned_of(skeleton, make_clip):
    clip = make_clip(9, seed=2)
    clip = replace(clip, values=clip.values * np.where(np.arange(clip.values.shape[1]) < 3, 1.0, 0.3))
    plain, _ = warned(skeleton, clip, reference="first")
    other, reported = warned(skeleton, stood_along_z(clip))
    assert other == pytest.approx(plain, abs=1e-9)
    assert [
        message for message in reported if "along Y at rest, along Z in most of the motion: Z is assumed" in message
    ]


def test_a_performer_who_lies_is_warned_of_and_the_rest_pose_decides(skeleton, make_clip):
    clip = make_clip(9)
    values = clip.values.copy()
    values[:, 3] = 90.0  # about Z
    other, reported = warned(skeleton, replace(clip, values=values))
    assert [message for message in reported if "no trunk that is upright" in message and "Y is assumed" in message]
    ways = other[:, skeleton.names.index("Head"), :3, 3] - other[:, 0, :3, 3]
    assert np.abs(ways[:, 0]).min() > 0.5


@pytest.mark.parametrize(("bone", "other"), [("Leg", "Foot"), ("UpLeg", "Leg")])
def test_a_limb_of_which_a_bone_is_missing_does_not_follow_and_is_named(skeleton, make_clip, bone, other):
    clip = renamed(make_clip(5, seed=2), lambda name: "Mystery" if name == "Left" + bone else name)
    poses, reported = warned(skeleton, clip)
    assert "which keep their rest pose: left leg (" in reported[0] and "joints" in reported[0]
    assert reported[1].endswith("LeftUpLeg, Mystery, LeftFoot" if bone == "Leg" else "Mystery, LeftLeg, LeftFoot")
    hips, thigh = (skeleton.names.index(name) for name in ("Hips", "LeftUpLeg"))
    turns = poses[:, hips, :3, :3].transpose(0, 2, 1) @ poses[:, thigh, :3, :3]
    assert turns == pytest.approx(np.broadcast_to(np.eye(3), turns.shape), abs=1e-12)
    paired, reported = warned(skeleton, clip, joints=(("Left" + bone, "Mystery"),))
    assert reported == [] and paired.tobytes() == warned(skeleton, make_clip(5, seed=2))[0].tobytes()


def test_unmatched_joints_are_in_the_json_of_a_run(make_clip, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_bvh(tmp_path / "clip.bvh", make_clip(3, seed=1))
    motion = 'head.type = "make_bust"\nmotion = { type = "load_motion", in.rest = "head", file = "clip.bvh", at = 1 }\n'
    (tmp_path / "shot.toml").write_text(f"schema = 1\nframes = [1, 1]\nfps = 24\n{motion}")
    result = CliRunner().invoke(commands, ["run", "shot.toml", "--cache", "c", "-j", "1", "--json"])
    (warning,) = json.loads(result.stdout)["warnings"]
    assert warning["node"] == "motion"
    assert warning["message"].endswith("LeftUpLeg, LeftLeg, LeftFoot, RightUpLeg, RightLeg, RightFoot")


def test_every_joint_of_a_clip_is_used_or_named(make_clip):
    clip = make_clip(3, seed=1)
    follows = build_retarget(build_skeleton(), clip, up=None, reference=None, unit=None, joints=()).follows
    _, reported = warned(build_skeleton(), clip)
    named = reported[-1].partition(": ")[2].split(", ")
    used = {clip.names[joint] for joint in follows} | {"Hips"}  # the hips carry the chest
    assert used | set(named) == set(clip.names) and not used & set(named)


def with_positions(clip: Clip, joint: str, ways: np.ndarray) -> Clip:
    """A clip with position channels of one joint [clip units], (F, 3)."""
    place = clip.names.index(joint)
    column = sum(map(len, clip.channels[:place]))
    names = ("Xposition", "Yposition", "Zposition", *clip.channels[place])
    values = np.insert(clip.values, [column] * 3, clip.offsets[place] + ways, axis=1)
    return replace(clip, channels=(*clip.channels[:place], names, *clip.channels[place + 1 :]), values=values)


@pytest.mark.parametrize("joint", ["Spine", "Head", "LeftForeArm"])
def test_translations_of_joints_are_retargeted(skeleton, make_clip, joint):
    clip, ways = make_clip(6), np.outer(np.arange(6.0), [0.01, 0.03, -0.02])
    plain, _ = warned(skeleton, clip)
    other, _ = warned(skeleton, with_positions(clip, joint, ways))
    moved = other[:, skeleton.names.index(joint), :3, 3] - plain[:, skeleton.names.index(joint), :3, 3]
    assert moved == pytest.approx(ways, abs=1e-12)
    still, _ = warned(skeleton, with_positions(clip, joint, 0.0 * ways + 0.1))
    assert still.tobytes() == plain.tobytes(), "longer bones, which the body does not have"


def test_a_joint_between_two_that_are_followed_stretches_what_is_above_it(make_clip):
    """The bust has no joint for the performer's hips and spine but the chest: its neck moves with the neck."""
    clip, ways = make_clip(6), np.outer(np.arange(6.0), [0.0, 0.02, 0.0])
    bust, unit = build_skeleton(), {"unit": 1.0}
    plain, _ = warned(bust, clip, **unit)
    other, _ = warned(bust, with_positions(clip, "Neck", ways), **unit)
    moved = (other - plain)[:, :, :3, 3]
    for joint, name in enumerate(bust.names):
        assert moved[:, joint] == pytest.approx(0.0 * ways if name == "chest" else ways, abs=1e-12)


def test_yaw_turns_the_whole_motion(skeleton, make_clip):
    clip, turn = make_clip(5, seed=2), Rotation.from_euler("y", 180.0, degrees=True).as_matrix()
    plain, other = warned(skeleton, clip)[0], warned(skeleton, clip, yaw=180.0)[0]
    assert other[..., :3, :3] == pytest.approx(turn @ plain[..., :3, :3], abs=1e-12)
    assert other[..., :3, 3] == pytest.approx(plain[..., :3, 3] @ turn.T, abs=1e-9)
    playback = Playback(None, None, None, None, (), yaw=90.0)
    assert pose_at(skeleton, clip, 0.0, 1.0, playback).transforms[0, 2, 0] == pytest.approx(
        -plain[0, 0, 0, 0], abs=1e-9
    )


def test_a_body_that_faces_back_follows_as_one_that_faces_ahead(skeleton, make_clip):
    clip, turn = make_clip(5, seed=2), Rotation.from_euler("y", 180.0, degrees=True).as_matrix()
    rest = skeleton.rest.copy()
    rest[:, :3] = turn @ rest[:, :3]
    plain, (other, reported) = warned(skeleton, clip)[0], warned(replace(skeleton, rest=rest), clip)
    assert other == pytest.approx(plain, abs=1e-9)
    assert "faces 180 degrees from +Z" in reported[0]


def test_a_pair_may_give_the_clip_its_trunk(skeleton, make_clip):
    clip = renamed(
        in_axes(make_clip(5, seed=2), Y_TO_Z), lambda name: {"Hips": "Mitte", "Head": "Kopf"}.get(name, name)
    )
    pairs = (("Hips", "Mitte"), ("Head", "Kopf"))
    other, reported = warned(skeleton, clip, joints=pairs, reference="zero")
    assert reported == [] and other == pytest.approx(
        warned(skeleton, make_clip(5, seed=2), reference="zero")[0], abs=1e-9
    )
    with pytest.raises(BadInput, match="the clip has no joint 'Kopff'"):
        warned(skeleton, clip, joints=(("Head", "Kopff"),))


def roles_of(clip) -> dict:
    return find_roles(clip.names)


def turned(clip, matrix):
    """The same performer drawn in other axes."""
    return replace(clip, offsets=clip.offsets @ matrix.T, ends=clip.ends @ matrix.T)


def test_the_zero_pose_is_taken_where_it_stands(make_clip):
    reference = find_reference(make_clip(2), roles_of(make_clip(2)), None, None)
    assert reference.drawn
    np.testing.assert_array_equal(reference.world, np.eye(3))
    np.testing.assert_allclose(reference.heading, np.eye(3), atol=1e-12)


def test_z_up_is_inferred_from_the_zero_pose(make_clip):
    y_to_z = Rotation.from_euler("x", 90.0, degrees=True).as_matrix()
    clip = turned(make_clip(2), y_to_z)
    reference = find_reference(clip, roles_of(clip), None, None)
    upright = find_reference(make_clip(2), roles_of(clip), None, None).positions
    shape = reference.positions - reference.positions[0]
    assert reference.drawn
    np.testing.assert_allclose(shape, upright - upright[0], atol=1e-12)


def test_a_zero_pose_that_lies_down_gives_way_to_the_first_frame(make_clip):
    clip = turned(make_clip(2, seed=1), Rotation.from_euler("z", 90.0, degrees=True).as_matrix())
    reference = find_reference(clip, roles_of(clip), None, None)
    assert not reference.drawn
    assert find_reference(clip, roles_of(clip), None, "zero").drawn


@pytest.mark.parametrize("degrees", [0.0, 30.0, 135.0, 180.0, -90.0])
def test_heading_is_read_from_left_and_right(make_clip, degrees):
    clip = make_clip(1)
    turn = Rotation.from_euler("y", degrees, degrees=True).as_matrix()
    positions = find_reference(clip, roles_of(clip), "y", "zero").positions @ turn.T
    np.testing.assert_allclose(find_heading(positions, roles_of(clip)), turn, atol=1e-12)


def test_unknown_people_stand_along_y_and_face_z():
    np.testing.assert_array_equal(standing_direction(np.zeros((1, 3)), {}), [0.0, 1.0, 0.0])
    np.testing.assert_array_equal(find_heading(np.zeros((1, 3)), {}), np.eye(3))


def a_pose(skeleton: Skeleton, degrees: float) -> Skeleton:
    """Lower the arms of a T pose."""
    rest, tips = skeleton.rest.copy(), skeleton.tips.copy()
    for side, sign in (("Left", -1.0), ("Right", 1.0)):
        shoulder = rest[skeleton.names.index(f"{side}Arm"), :3, 3].copy()
        turn = Rotation.from_euler("z", sign * degrees, degrees=True).as_matrix()
        for part in ("Arm", "ForeArm", "Hand"):
            joint = skeleton.names.index(side + part)
            rest[joint, :3, 3] = shoulder + turn @ (rest[joint, :3, 3] - shoulder)
    return replace(skeleton, rest=rest, tips=tips)


def test_arms_of_an_a_pose_meet_a_t_pose_by_the_angle_between(make_clip, skeleton):
    clip = make_clip(1)
    reference = find_reference(clip, roles_of(clip), "y", "zero")
    turns = align_parts(a_pose(skeleton, 40.0).rest[:, :3, 3], find_roles(skeleton.names), roles_of(clip), reference)
    raised = Rotation.from_euler("z", 40.0, degrees=True).as_matrix()
    for part in ("upperarm", "forearm", "hand"):
        np.testing.assert_allclose(turns[Role(part, "left")], raised, atol=1e-9)
        np.testing.assert_allclose(turns[Role(part, "right")], raised.T, atol=1e-9)
    for role in (Role("hips"), Role("spine"), Role("thigh", "left"), Role("foot", "right")):
        np.testing.assert_allclose(turns[role], np.eye(3), atol=1e-9)
    assert Role("head") not in turns
