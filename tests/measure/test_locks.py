"""What locks leave to be simulated: hair that parts counts until it follows, leads or is audited."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.data import Groom, Mesh, Strands
from hairpipe.data.hair import HairState
from hairpipe.groom.binding import root_frames
from hairpipe.measure.locks import measure_locks
from hairpipe.sim.locks.grouping import is_carried
from hairpipe.sim.locks.locked_frame import no_locks
from hairpipe.sim.locks.places import find_places

HAIRS, POINTS = 4, 6
OFFSETS = np.arange(0, HAIRS * POINTS + 1, POINTS, dtype=np.int32)
CORNERS, TRIANGLE = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, -0.1]]), np.array([[0, 1, 2]], np.int32)
GROUPINGS = [  # leaders and audited guides, frame by frame, and the share of what is simulated that has parted [%]
    ([0, 1, 2, 3], [-1, -1, -1, -1], 0.0),
    ([0, 0, 0, 3], [-1, -1, -1, -1], 0.0),
    ([0, 0, 2, 3], [-1, -1, -1, -1], 100.0 / 3.0),
    ([0, 1, 2, 3], [-1, 0, -1, -1], 100.0 / 4.0),
    ([0, 1, 2, 3], [-1, -1, -1, -1], 200.0 / 4.0),
    ([0, 1, 2, 2], [-1, -1, -1, -1], 100.0 / 3.0),
]


@pytest.fixture
def groom():
    """Straight hairs beside each other."""
    roots = np.array([0.03, 0.0, -0.03]) + 1e-3 * np.arange(HAIRS)[:, None] * np.array([1.0, 0.0, 0.0])
    points = (roots[:, None] + np.linspace(0.0, 0.1, POINTS)[:, None] * np.array([0.0, 1.0, 0.0])).reshape(-1, 3)
    triangles, ids = np.zeros(HAIRS, np.int32), np.arange(HAIRS, dtype=np.int32)
    weights = np.stack([1.0 - 10.0 * (roots[:, 0] - roots[:, 2]), 10.0 * roots[:, 0], -10.0 * roots[:, 2]], 1)
    frames = root_frames(CORNERS, TRIANGLE, triangles, weights)
    return Groom(points, OFFSETS, ids, triangles, weights, frames, np.zeros((HAIRS, 2), np.float32))


def state(groom, leaders, audited):
    leaders, audited = np.array(leaders, np.int32), np.array(audited, np.int32)
    among, still = is_carried(leaders, audited), np.tile(np.eye(3), (OFFSETS[-1], 1, 1))
    places = find_places(groom.points, OFFSETS, np.flatnonzero(~among), np.flatnonzero(among), still)
    locks = replace(no_locks(HAIRS), leaders=leaders, audited=audited, **places._asdict())
    never = np.empty((0, 2), np.int32), np.empty((0, 2))
    return HairState(*[np.empty(0)] * 6, *never, pace=np.inf, stretched=1.0, locks=locks)


def measured(groom, moved):
    """Measure the groupings, with hair where it is moved to at each frame; the body turns about the vertical."""
    hair, bodies, states = {}, {}, {}
    for frame, (leaders, audited, _) in enumerate(GROUPINGS):
        c, s = np.cos(0.3 * frame), np.sin(0.3 * frame)
        turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
        points = moved(frame, groom.points) @ turn.T
        hair[frame] = Strands(points, np.zeros(points.shape, np.float32), OFFSETS, np.full(len(points), 1e-4))
        bodies[frame] = Mesh(CORNERS @ turn.T, TRIANGLE, np.zeros((3, 3)))
        states[frame] = state(groom, leaders, audited)
    return measure_locks(groom, hair, states, None, bodies, 24.0)


def test_hair_has_parted_from_when_it_followed_until_it_follows_or_leads_or_is_audited(groom):
    table = measured(groom, lambda frame, points: points)
    parted = [parted for *_, parted in GROUPINGS]
    np.testing.assert_allclose(table["of them parted [%]"], parted)
    np.testing.assert_allclose(table["could follow [%]"], parted)  # it goes rigidly with what it followed


def test_hair_could_follow_up_to_where_it_has_been_off(groom):
    def moved(frame, points):
        out = points.copy()
        if frame == 3:
            out[2 * POINTS + 4 : 3 * POINTS, 0] += 0.05  # the tip of hair 2, which has parted one frame before
        return out

    table = measured(groom, moved)
    share = 3.0 / (POINTS - 1)
    expected = [0.0, 0.0, 100.0 / 3.0, 100.0 * share / 4.0, 100.0 * (1.0 + share) / 4.0, 100.0 / 3.0]
    np.testing.assert_allclose(table["could follow [%]"], expected)


def test_without_a_body_nobody_can_tell(groom):
    states = {frame: state(groom, *grouping[:2]) for frame, grouping in enumerate(GROUPINGS)}
    hair = Strands(groom.points, np.zeros(groom.points.shape, np.float32), OFFSETS, np.full(len(groom.points), 1e-4))
    table = measure_locks(groom, dict.fromkeys(states, hair), states, None, None, 24.0)
    assert np.isnan(table["of them parted [%]"]).all() and np.isnan(table["could follow [%]"]).all()
