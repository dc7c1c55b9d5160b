"""Natural curvature of strands."""

import numpy as np
import pytest

from hairpipe.groom.curving import curved, radii_of
from hairpipe.groom.strands import unbound
from hairpipe.values.groom import segment_lengths
from hairpipe.values.strand_arrays import take

COUNT = 40
LINES = np.tile(0.005 * np.arange(COUNT + 1)[:, None] * [0.0, -1.0, 0.0], (30, 1, 1))
"""Straight strands of 20 cm."""


def groom_of(points):
    return unbound(points, np.tile(np.eye(3, 4), (len(points), 1, 1)))


def turns(groom):
    ways = np.diff(groom.points.reshape(-1, COUNT + 1, 3), axis=1)
    tangents = ways / np.linalg.norm(ways, axis=2, keepdims=True)
    return np.arccos(np.clip(np.sum(tangents[:, 1:] * tangents[:, :-1], axis=2), -1.0, 1.0))


def test_straight_strands_become_arcs_in_planes_of_all_directions():
    groom = groom_of(LINES)
    arcs = curved(groom, 0.044, 0.0, 0)
    np.testing.assert_allclose(turns(arcs), 0.005 / 0.044, rtol=1e-9)
    np.testing.assert_allclose(
        segment_lengths(arcs.points, arcs.offsets), segment_lengths(groom.points, groom.offsets), rtol=1e-12
    )
    points = arcs.points.reshape(-1, COUNT + 1, 3)
    np.testing.assert_array_equal(points[:, :2], LINES[:, :2])
    assert max(np.linalg.svd(strand - strand[0])[1][2] for strand in points) < 1e-12
    away = points[:, -1, [0, 2]] / np.linalg.norm(points[:, -1, [0, 2]], axis=1, keepdims=True)
    assert np.linalg.norm(away.mean(axis=0)) < 0.4


def test_curvatures_add_up_and_none_leaves_a_groom_as_it_is():
    arcs = curved(groom_of(LINES), 0.044, 0.0, 0)
    np.testing.assert_allclose(turns(curved(arcs, 0.022, 0.0, 0)), 0.005 * (1 / 0.044 + 1 / 0.022), rtol=1e-9)
    np.testing.assert_allclose(curved(arcs, 1e9, 0.0, 0).points, arcs.points, atol=1e-9)


def test_radii_have_their_mean_and_deviation_and_range_as_measured_hair():
    radii = radii_of(np.arange(2300), 0.044, 0.023, 0)
    assert radii.mean() == pytest.approx(0.044, rel=0.03)
    assert radii.std() == pytest.approx(0.023, rel=0.1)
    assert 0.004 < radii.min() < 0.012 and 0.1 < radii.max() < 0.3  # measured: 0.6 to 16 cm


def test_a_strand_does_not_depend_on_the_others():
    groom = groom_of(LINES)
    some = np.array([3, 17])
    np.testing.assert_array_equal(
        curved(take(groom, some), 0.044, 0.023, 5).points.reshape(2, -1, 3),
        curved(groom, 0.044, 0.023, 5).points.reshape(30, -1, 3)[some],
    )
