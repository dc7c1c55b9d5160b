"""What locks leave to be simulated, and what frames cost."""

import inspect
import math
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.engine import Reached, Spent
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.around import Around
from hairpipe.graphs.experiments.nodes.restart_hair import restart_hair
from hairpipe.measure.locks import measure_locks
from hairpipe.measure.motion import COST_COLUMNS
from hairpipe.nodes.measure_cost import measure_cost
from hairpipe.nodes.simulate_hair import simulate_hair
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


def spent(seconds):
    """Give what frames from 5 on took: all threads twice as long as what passed."""
    taken = {frame: Spent(value / 2, value) for frame, value in enumerate(seconds, 5)}
    return Reached(tuple(taken), taken.__getitem__)


def row(table):
    return [table[name][0] for name in COST_COLUMNS]


def test_the_first_frames_do_not_count_and_nodes_add_up():
    table = measure_cost((spent([9.0, 8.0, 1.0, 2.0, 6.0, 7.0]), spent([1.0] * 6)), warm=1, timed=3)
    assert row(table) == [3.0, 2.0, 7.0, 3]


@pytest.mark.parametrize("seconds", [[9.0, 3.0], [9.0, 4.0, 3.0]])
def test_a_shot_of_few_frames_is_timed_by_its_last(seconds):
    assert row(measure_cost((spent(seconds),), warm=4, timed=8)) == [3.0, 3.0, 3.0, 1]


def test_one_frame_alone_has_no_cost():
    first, *_, count = row(measure_cost((spent([9.0]),)))
    assert math.isnan(first) and count == 0


def test_a_node_that_diverged_ends_the_measurement():
    table = measure_cost((spent([9.0, 1.0, 2.0]), spent([9.0, 1.0, 2.0, 3.0, 4.0])), warm=1, timed=8)
    assert row(table) == [4.0, 4.0, 4.0, 1]


def test_a_restart_takes_the_settings_of_the_simulation():
    ours, theirs = (inspect.signature(function).parameters for function in (restart_hair, simulate_hair))
    settings = {name: (p.annotation, p.default) for name, p in theirs.items() if p.kind is p.KEYWORD_ONLY}
    assert settings.items() <= {name: (p.annotation, p.default) for name, p in ours.items()}.items()


def test_frames_that_are_omitted_are_refused_where_hair_would_restart():
    shot = Reached((5, 6, 9), lambda frame: frame)
    assert Around(None, shot, (), ()).frames(5, 2) == [5, 6]
    with pytest.raises(BadInput, match=r"no frames between 6 and 9.*\(4 of them in a row\)"):
        Around(None, shot, (), ()).frames(5, 4)
