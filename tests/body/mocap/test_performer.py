from itertools import permutations

import numpy as np
import pytest

from hairpipe.body.performer import chain, local_positions, place_at_zero, place_joints
from hairpipe.values.body import Clip

CHANCE = np.random.default_rng(5)
POSITIONS = ("Xposition", "Yposition", "Zposition")


def about(axis: str, degrees: float) -> np.ndarray:
    """The textbook matrices, written out."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    rows = {
        "X": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "Y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "Z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(rows[axis])


def one_joint(channels: tuple[str, ...], values: np.ndarray, offset=(0.0, 0.0, 0.0)) -> Clip:
    return Clip(("a",), np.array([-1], np.int32), np.array([offset]), np.full((1, 3), np.nan), (channels,), values, 0.1)


@pytest.mark.parametrize("order", ["".join(p) for n in (1, 2, 3) for p in permutations("XYZ", n)] + ["XYX", "ZXZ"])
def test_rotation_is_the_product_of_the_channels_in_their_order(order):
    angles = CHANCE.uniform(-180.0, 180.0, (1, len(order)))
    expected = np.eye(3)
    for axis, angle in zip(order, angles[0], strict=True):
        expected = expected @ about(axis, angle)
    clip = one_joint(tuple(f"{axis}rotation" for axis in order), angles)
    np.testing.assert_allclose(place_joints(clip, np.zeros(1)).rotations[0, 0], expected, atol=1e-12)


@pytest.mark.parametrize("places", list(permutations(range(6)))[::97])
def test_positions_and_rotations_may_be_mixed_in_any_order(places):
    names = (*POSITIONS, "Xrotation", "Yrotation", "Zrotation")
    mixed = tuple(names[place] for place in places)
    values = CHANCE.uniform(-90.0, 90.0, (1, 6))
    placement = place_joints(one_joint(mixed, values), np.zeros(1))
    reported = dict(zip(mixed, values[0], strict=True))
    np.testing.assert_allclose(placement.positions[0, 0], [reported[name] for name in POSITIONS])
    expected = np.eye(3)
    for name in mixed:
        if name.endswith("rotation"):
            expected = expected @ about(name[0], reported[name])
    np.testing.assert_allclose(placement.rotations[0, 0], expected, atol=1e-12)


def test_chain_of_three_joints_by_hand():
    rotations = np.array([[about("Z", 90.0), about("Y", 90.0), about("X", 30.0)]])
    offsets = np.array([[[1.0, 0, 0], [2.0, 0, 0], [0, 0, 3.0]]])
    placed = chain(np.array([-1, 0, 1]), rotations, offsets)
    np.testing.assert_allclose(placed.positions[0], [[1, 0, 0], [1, 2, 0], [1, 5, 0]], atol=1e-12)
    np.testing.assert_allclose(
        placed.rotations[0, 2], about("Z", 90.0) @ about("Y", 90.0) @ about("X", 30.0), atol=1e-12
    )


def test_between_frames_rotations_go_the_shorter_way_and_positions_straight():
    clip = one_joint(("Xposition", "Yrotation"), np.array([[0.0, 170.0], [2.0, -170.0]]))
    placed = place_joints(clip, np.array([0.25, 0.5]))
    np.testing.assert_allclose(placed.positions[:, 0, 0], [0.5, 1.0])
    np.testing.assert_allclose(placed.rotations[0, 0], about("Y", 175.0), atol=1e-12)
    np.testing.assert_allclose(placed.rotations[1, 0], about("Y", 180.0), atol=1e-12)


@pytest.mark.parametrize("frames", [1, 2, 5])
def test_motion_continues_beyond_the_ends(frames):
    values = np.arange(1.0, frames + 1.0)[:, None] * [1.0, 30.0]
    placed = place_joints(one_joint(("Xposition", "Yrotation"), values), np.array([-0.4, 0.0, frames - 1.0, frames]))
    beyond = np.array([0.6, 1.0, frames, frames + 1.0]) if frames > 1 else np.ones(4)
    np.testing.assert_allclose(placed.positions[:, 0, 0], beyond)
    np.testing.assert_allclose(placed.rotations[:, 0], [about("Y", 30.0 * x) for x in beyond], atol=1e-12)


def child_clip(first: float) -> Clip:
    offsets = np.array([[0.0, 94.0, 0.0], [0.0, 10.0, 0.0]])
    values = np.array([[1.0, first], [2.0, first + 0.5]])
    channels = (("Yposition",), ("Yposition",))
    return Clip(("a", "b"), np.array([-1, 0], np.int32), offsets, np.full((2, 3), np.nan), channels, values, 0.1)


def test_positions_stand_for_offsets():
    np.testing.assert_allclose(local_positions(child_clip(0.2), np.array([0, 1]))[..., 1], [[1, 0.2], [2, 0.7]])


def test_zero_pose_adds_up_the_offsets():
    np.testing.assert_allclose(place_at_zero(child_clip(0.0)).positions[0], [[0, 94, 0], [0, 104, 0]])
