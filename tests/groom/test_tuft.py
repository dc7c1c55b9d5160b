"""Tufts: rows of strands, each turned as a whole."""

import numpy as np

from hairpipe.groom.settings import Tuft
from hairpipe.groom.strands import gather_tuft, lay_strands, rotations

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
