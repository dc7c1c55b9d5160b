"""What locks leave to be simulated: hair that parts counts until it follows, leads or is audited."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.data import Groom, Strands
from hairpipe.data.hair import HairState
from hairpipe.measure.locks import measure_locks
from hairpipe.sim.locks.locked_frame import no_locks

HAIRS = 4
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
    points = np.zeros((2 * HAIRS, 3))
    points[1::2, 1] = 0.1
    offsets, ids = np.arange(0, 2 * HAIRS + 1, 2, dtype=np.int32), np.arange(HAIRS, dtype=np.int32)
    return Groom(
        points, offsets, ids, np.zeros(HAIRS, np.int32), *(np.zeros((HAIRS, *n)) for n in ((3,), (3, 4), (2,)))
    )


def state(leaders, audited):
    locks = replace(no_locks(HAIRS), leaders=np.array(leaders, np.int32), audited=np.array(audited, np.int32))
    never = np.empty((0, 2), np.int32), np.empty((0, 2))
    return HairState(*[np.empty(0)] * 6, *never, pace=np.inf, stretched=1.0, locks=locks)


def test_hair_has_parted_from_when_it_followed_until_it_follows_or_leads_or_is_audited(groom):
    hair = Strands(groom.points, groom.points.astype(np.float32), groom.offsets, np.full(len(groom.points), 1e-4))
    states = {frame: state(*grouping[:2]) for frame, grouping in enumerate(GROUPINGS)}
    table = measure_locks(groom, dict.fromkeys(states, hair), states, None, 24.0)
    np.testing.assert_allclose(table["of them parted [%]"], [parted for *_, parted in GROUPINGS])
