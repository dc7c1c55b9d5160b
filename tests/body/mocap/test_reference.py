from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.body.retarget import align_parts, find_heading, find_reference, standing_direction
from hairpipe.body.roles import Role, find_roles
from hairpipe.values import Skeleton


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
