"""Strands by themselves: of the length and shape that was asked for, in segments of equal length."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix
from hairpipe.groom.settings import Tuft
from hairpipe.groom.strands import gather_tuft, lay_strands, rotations

LENGTH = 0.3
CURL = Helix(0.015, 0.02)
components = st.floats(-3.0, 3.0)


def strand(segments=50, direction=(1.0, 0.0, 0.0), curl=None, arch=0.0, count=1) -> np.ndarray:
    groom = lay_strands(count, LENGTH, segments, direction, (0.0, 0.0, 0.01), curl, arch)
    return groom.points.reshape(count, segments + 1, 3)


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 80), st.tuples(components, components, components), st.sampled_from([(None, 0), (None, 0.4)]))
def test_segments_are_equal_and_add_up(segments, direction, shape):
    if np.linalg.norm(direction) > 1e-3:
        chords = np.linalg.norm(np.diff(strand(segments, direction, *shape), axis=1), axis=2)
        np.testing.assert_allclose(chords, LENGTH / segments, rtol=1e-12)


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, -2.0, 0.0), (0.3, 0.999, 0.0), (1.0, 1.0, -1.0)])
def test_a_curl_lies_on_its_helix_and_turns_to_the_right(direction):
    groom = lay_strands(2, LENGTH, 60, direction, (0.0, 0.0, 0.01), CURL, 0.0)
    ahead = np.array(direction) / np.linalg.norm(direction)
    np.testing.assert_allclose(groom.root_frames[:, :, 2], [ahead, ahead])
    points = groom.points[:61] - groom.root_frames[0, :, 3]
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), LENGTH / 60, rtol=1e-12)
    heights = points @ ahead
    out = points - heights[:, None] * ahead + CURL.radius * groom.root_frames[0, :, 0]
    np.testing.assert_allclose(np.linalg.norm(out, axis=1), CURL.radius, rtol=1e-12)
    turns = np.cross(out[:-1], out[1:]) @ ahead
    assert (turns > 0).all()
    angle = np.arcsin(turns[0] / CURL.radius**2)
    np.testing.assert_allclose(np.diff(heights), CURL.pitch * angle / (2 * np.pi), rtol=1e-9)


def test_an_arch_rises_as_high_as_it_should_and_ends_on_its_line():
    points = strand(400, arch=0.25)[0]
    span = points[-1, 0]
    np.testing.assert_allclose(points[-1, 1:], 0.0, atol=1e-12)
    np.testing.assert_allclose(points[:, 1], points[:, 0] * (1 - points[:, 0] / span), atol=1e-5 * LENGTH)
    assert strand(arch=-0.25)[0, :, 1].max() == 0.0
    assert strand(direction=(0.0, 1.0, 0.0), arch=0.25)[0, 25, 2] > 0.2 * span


def test_roots_stand_in_a_row_with_frames_that_are_rotations():
    groom = lay_strands(3, LENGTH, 5, (0.0, -1.0, 0.2), (0.01, 0.02, 0.03), None, 0.0)
    np.testing.assert_allclose(groom.points[groom.offsets[:-1]], np.arange(3)[:, None] * [0.01, 0.02, 0.03])
    np.testing.assert_array_equal(groom.root_frames[:, :, 3], groom.points[groom.offsets[:-1]])
    turn = groom.root_frames[0, :, :3]
    np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=1e-15)
    assert np.linalg.det(turn) > 0.999
    assert groom.offsets.tolist() == [0, 6, 12, 18] and groom.root_barycentrics.sum() == 3.0


def test_impossible_settings_are_refused():
    with pytest.raises(BadInput, match="no length"):
        strand(direction=(0.0, 0.0, 0.0))
    with pytest.raises(BadInput, match="curled or arched"):
        strand(curl=CURL, arch=0.1)
    with pytest.raises(BadInput, match="half a turn each") as caught:
        strand(5, curl=Helix(0.001, 0.001))
    fewest = int(str(caught.value).rpartition("segments >= ")[2].rstrip(")"))
    assert strand(fewest, curl=Helix(0.001, 0.001)).shape == (1, fewest + 1, 3)


ROW = lay_strands(5, 0.2, 4, (0.0, -1.0, 0.0), (0.0, 0.0, 0.01), None, 0.3)


def test_without_stray_all_rows_are_the_first_one_moved():
    tuft = gather_tuft(ROW, Tuft(rows=3, apart=(0.02, 0.0, 0.0)))
    rows = tuft.points.reshape(3, -1, 3)
    for k in range(3):
        np.testing.assert_allclose(rows[k], ROW.points + np.array([0.02 * k, 0.0, 0.0]), atol=1e-15)
    assert tuft.ids.tolist() == list(range(15)) and tuft.offsets[-1] == len(tuft.points)
    np.testing.assert_array_equal(tuft.root_frames[:, :, 3], tuft.points[tuft.offsets[:-1]])


def test_strands_are_turned_with_their_roots_by_as_much_as_was_requested():
    tuft = gather_tuft(ROW, Tuft(rows=400, stray=3.0))
    straight = gather_tuft(ROW, Tuft(rows=400))
    turns = tuft.root_frames[:, :, :3] @ straight.root_frames[:, :, :3].transpose(0, 2, 1)
    np.testing.assert_allclose(turns @ turns.transpose(0, 2, 1), np.tile(np.eye(3), (2000, 1, 1)), atol=1e-12)
    roots = straight.root_frames[:, None, :, 3]
    shapes = np.einsum("sij,spj->spi", turns, straight.points.reshape(2000, 5, 3) - roots)
    np.testing.assert_allclose(tuft.points.reshape(2000, 5, 3), roots + shapes, atol=1e-12)
    ahead, before = (groom.root_frames[:, :, 2] for groom in (tuft, straight))
    angles = np.degrees(np.arccos(np.sum(ahead * before, axis=1)))
    assert 2.8 < np.sqrt(np.mean(angles**2)) < 3.2


def test_chance_is_that_of_the_seed():
    one, again, other = (gather_tuft(ROW, Tuft(rows=2, stray=3.0, seed=seed)).points for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, again)
    assert np.abs(one - other).max() > 1e-4


def test_rotations_turn_about_their_axis_to_the_left():
    quarter = rotations(np.array([[0.0, 0.0, np.pi / 2], [0.0, 0.0, 0.0]]))
    np.testing.assert_allclose(quarter[0] @ [1.0, 0.0, 2.0], [0.0, 1.0, 2.0], atol=1e-12)
    np.testing.assert_array_equal(quarter[1], np.eye(3))
