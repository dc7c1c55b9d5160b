"""What locks leave to be simulated, and what of it has released; what audits found."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.measure.locks import measure_locks
from hairpipe.values import Groom, Strands
from hairpipe.values.hair import AUDITED, FOLLOWER, GUIDE, RELEASED, TRIED, Audit, HairState, no_locks

HAIRS, POINTS = 4, 6
OFFSETS = np.arange(0, HAIRS * POINTS + 1, POINTS, dtype=np.int32)


@pytest.fixture
def groom():
    """Straight hairs beside each other."""
    points = np.zeros((HAIRS, POINTS, 3))
    points[..., 0], points[..., 1] = np.arange(HAIRS)[:, None], np.linspace(0.0, 0.1, POINTS)
    ids, frames = np.arange(HAIRS, dtype=np.int32), np.tile(np.eye(3), (HAIRS, 1, 1))
    weights = np.full((HAIRS, 3), 1.0 / 3.0)
    return Groom(points.reshape(-1, 3), OFFSETS, ids, ids * 0, weights, frames, np.zeros((HAIRS, 2), np.float32))


def measured(groom, *states):
    """Tabulate so many frames, whose locks have the fields that are given."""
    never = np.empty((0, 2), np.int32), np.empty((0, 2))
    hair = Strands(groom.points, np.zeros(groom.points.shape, np.float32), OFFSETS, np.full(len(groom.points), 1e-4))
    known = {}
    for frame, fields in enumerate(states):
        locks = fields and replace(no_locks(HAIRS), **fields)
        known[frame] = HairState(*[np.empty(0)] * 6, *never, pace=np.inf, stretched=1.0, locks=locks)
    return measure_locks(groom, dict.fromkeys(known, hair), known, None, 24.0)


def in_roles(*roles, guides):
    return {"roles": np.array(roles, np.uint8), "guides": np.array(guides, np.int32)}


def test_shares_of_simulated_and_released_strands(groom):
    table = measured(
        groom,
        None,
        in_roles(GUIDE, FOLLOWER, FOLLOWER, FOLLOWER, guides=[0, 0, 0, 0]),
        in_roles(GUIDE, FOLLOWER, RELEASED, FOLLOWER, guides=[0, 0, 0, 0]),
        in_roles(GUIDE, TRIED, RELEASED, AUDITED, guides=[0, 0, 0, 0]),
    )
    np.testing.assert_allclose(table["simulated [%]"], [100.0, 25.0, 50.0, 100.0])
    np.testing.assert_allclose(table["released, of simulated [%]"], [0.0, 0.0, 50.0, 50.0])
    np.testing.assert_array_equal(table["largest lock"], [1, 4, 3, 1])


def test_an_audit_is_averaged_over_its_strands(groom):
    audit = Audit(np.array([3e-3, 4e-3]), np.array([3, 1]))
    table = measured(groom, {"turn": 1}, {"audit": audit})
    np.testing.assert_array_equal(table["audited strands"], [0, 4])
    np.testing.assert_allclose(table["audit error [mm]"][1], np.sqrt(0.25 * (3 * 9.0 + 16.0)))
