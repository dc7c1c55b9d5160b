"""Interpolated hair is outside of bodies, and as long as it was."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.geometry.collider import probe_union
from hairpipe.groom.strands import lay_strands
from hairpipe.levelset.bake import bake
from hairpipe.values import Mesh
from hairpipe.values.groom import segment_lengths
from hairpipe.values.strand_arrays import take

RADIUS, VOXEL = 0.05, 0.005
CENTRE = np.array([0.02, -0.07, 0.0])


@pytest.fixture(scope="module")
def surface(sphere):
    """A ball that rises at a metre a second."""
    mesh = sphere(RADIUS, CENTRE, level=4)
    return bake(Mesh(mesh.points, mesh.triangles, np.tile([0.0, 1.0, 0.0], (len(mesh.points), 1))), VOXEL, 8.0)


@pytest.fixture(scope="module")
def curtain():
    """Hairs of 24 segments that hang in a row, those at its ends beside the ball, others in it; the first and last."""
    hair = lay_strands(30, 0.12, 24, (0.0, -1.0, 0.0), (0.006, 0.0, 0.001), None, 0.0)
    hair = replace(hair, points=hair.points - (0.07, 0.0, 0.0))
    return hair, take(hair, np.array([0, 29]))


def heights(points):
    return np.linalg.norm(points - CENTRE, axis=1) - RADIUS


def test_no_point_is_left_inside_and_lengths_stay(curtain, surface, at, shown):
    groom, keys = curtain
    through = shown(at(keys, keys.points), keys, groom)
    found = shown(at(keys, keys.points), keys, groom, None, None, (surface,), thickness=2e-3)
    assert heights(through.points).min() < -0.03
    fifth = np.tile(np.arange(25) >= 5, 30)
    assert heights(found.points)[fifth].min() > 2e-3 - 0.1 * VOXEL
    rest, now = (segment_lengths(some.points, groom.offsets) for some in (groom, found))
    assert now == pytest.approx(rest, rel=1e-12)
    beside = heights(through.points).reshape(30, 25).min(axis=1) > 4e-3
    assert 5 < beside.sum() < 25
    assert np.array_equal(found.points.reshape(30, -1)[beside], through.points.reshape(30, -1)[beside])


def test_pushed_points_move_with_the_body(curtain, surface, at, shown):
    groom, keys = curtain
    found = shown(at(keys, keys.points), keys, groom, None, None, (surface,))
    normals = (found.points - CENTRE) / np.linalg.norm(found.points - CENTRE, axis=1, keepdims=True)
    moved = (found.points != shown(at(keys, keys.points), keys, groom).points).any(axis=1)
    touching = moved & (np.abs(heights(found.points) - 1e-3) < 1e-4)
    assert touching.sum() > 20
    assert (np.einsum("pi,pi->p", found.velocities - (0.0, 1.0, 0.0), normals)[touching] > -0.05).all()


def test_keys_stay_where_they_are(curtain, surface, at, shown):
    groom, _ = curtain
    found = shown(at(groom, groom.points), groom, groom, None, None, (surface,))
    assert np.array_equal(found.points, groom.points)


def test_hair_that_is_bent_into_the_body_comes_out(curtain, surface, at, shown, bent):
    groom, keys = curtain
    for seed in range(3):
        points = bent(keys, 60.0, seed)
        found = shown(at(keys, points), keys, groom, None, None, (surface,), thickness=2e-3)
        others = np.repeat(~np.isin(groom.ids, keys.ids), 25) & np.tile(np.arange(25) >= 5, 30)
        assert heights(found.points)[others].min() > 2e-3 - 0.1 * VOXEL


def test_any_number_of_threads_gives_the_same_bytes(curtain, surface, at, threads, shown):
    groom, keys = curtain
    found = []
    for count in (1, 2):
        threads(count)
        found.append(shown(at(keys, keys.points), keys, groom, None, None, (surface,)).points.tobytes())
    assert found[0] == found[1]


def test_nothing_is_probed_beyond_reach():
    points = np.zeros((3, 3))
    assert np.array_equal(probe_union([], points, np.array([0.1, 0.2, 0.3])).distance, [0.1, 0.2, 0.3])
