"""Normals of a shell are those of its surface, and go with the hair."""

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.errors import BadInput
from hairpipe.groom.interpolating import probe_shell
from hairpipe.levelset.bake import bake
from hairpipe.nodes.carry_normals import carry_normals

TURN = Track(times=(0.0, 1.0), turn=(0.0, 40.0), move=((0.0, 0.0, 0.0), (0.1, 0.2, 0.3)))
CENTRE = np.array([0.015, -0.05, 0.01])


@pytest.fixture(scope="module")
def shell(sphere):
    """A ball that the middle of the groom is in, and its ends within the band of."""
    return bake(sphere(0.04, CENTRE), 0.005, 8.0, "refuse")


def test_normals_of_a_ball_point_away_from_its_centre(groom, shell):
    rng = np.random.default_rng(3)
    ways = rng.normal(size=(500, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    points = CENTRE + ways * rng.uniform(0.02, 0.07, (500, 1))
    found = probe_shell(points, shell).normal
    assert np.einsum("pi,pi->p", found, ways).min() > np.cos(np.radians(2.0))
    assert not probe_shell(points + 1.0, shell).normal.any()


def test_hair_that_is_moved_rigidly_turns_its_normals_as_much(groom, at, shell):
    ends = drive(groom, 0.7, TURN, None, None, None)
    motion = ends.roots[0]
    assert np.abs(motion[:, :3] - np.eye(3)).max() > 0.1
    rest = probe_shell(groom.points, shell).normal
    found = carry_normals(at(groom, groom.points @ motion[:, :3].T + motion[:, 3]), groom, shell, None, ends)
    assert found.vectors == pytest.approx(rest @ motion[:, :3].T, abs=1e-6)


def test_a_normal_keeps_its_angle_to_hair_that_bends(groom, at, bent, shell):
    rest, points = probe_shell(groom.points, shell).normal, bent(groom, 40.0, 1)
    found = carry_normals(at(groom, points), groom, shell, None, None).vectors
    inner = np.setdiff1d(np.arange(len(points)), groom.offsets[1:] - 1)
    before, after = (
        np.einsum("pi,pi->p", n[inner], p[inner + 1] - p[inner]) for n, p in ((rest, groom.points), (found, points))
    )
    assert after == pytest.approx(before, abs=1e-7) and np.abs(found - rest).max() > 0.1


def test_other_strands_are_refused(groom, keys, at, shell):
    with pytest.raises(BadInput, match="not the same strands"):
        carry_normals(at(keys, keys.points), groom, shell, None, None)
