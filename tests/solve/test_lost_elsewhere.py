"""Strands that cannot be solved, in chains, in a volume and among locks: each gets as much help as it needs."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.laws.settings import Locks, StepControl, Stiction, Volume
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import Frame, next_state, start
from hairpipe.solve import lost
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

FRAME, SEGMENTS, LENGTH = 1 / 24, 10, 0.1
STEPS = StepControl(longest=1 / 240, travel=np.inf)
UNSOLVED = "had no solution"


@pytest.fixture
def strands(scene, straight):
    """Hair of a model, of strands that leave one plate this far from each other [m]."""

    def make(count, model="chain", apart=0.01):
        lines = [straight(LENGTH, SEGMENTS, [1, 0.2, 0]) + np.array([0.0, 0.0, apart * k]) for k in range(count)]
        return build_hair(scene(lines).hair.groom, Material(), model)

    return make


@pytest.fixture
def tries(monkeypatch):
    """Parts in which steps were done again, one number each time."""
    seen, do_again = [], lost.do_again

    def count(rule, model, state, began, who, step, around, parts=1):
        seen.append(parts)
        return do_again(rule, model, state, began, who, step, around, parts)

    monkeypatch.setattr(lost, "do_again", count)
    return seen


def thrown(hair, body, shot, speed, strand, state=None):
    """Advance a frame in which one strand begins with a speed [m/s]; return the state and what was said."""
    state = state or start(hair, body, shot)
    block, lane = np.argwhere(hair.layout.strands == strand)[0]
    rows, velocities = slice(hair.model.first[block], hair.model.first[block + 1]), state.velocities.copy()
    velocities[rows, :, lane][hair.model.shape.clamped :] = speed
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        after = next_state(hair, replace(state, velocities=velocities), Frame((body, body), (), (), 0.0, FRAME), shot)
    return after, [str(each.message) for each in caught]


def points_of(hair, state):
    return hair.layout.axis(state.positions).reshape(len(hair.groom.ids), -1, 3)


def stretch(points):
    return np.linalg.norm(np.diff(points, axis=1), axis=2).max() / (LENGTH / SEGMENTS)


@pytest.mark.parametrize(("speed", "parts", "held"), [(10.0, 1, False), (100.0, 8, False), (1e4, 8, True)])
def test_a_chain_goes_down_the_ladder_as_far_as_it_must(strands, triangle, tries, speed, parts, held):
    hair, body, shot = strands(3), triangle(), Scene(steps=STEPS)
    good, _ = thrown(hair, body, shot, 0.0, 1)
    assert not tries
    state, reported = thrown(hair, body, shot, speed, 1)
    assert max(tries) == parts
    assert any(UNSOLVED in each for each in reported) == held
    points, others = points_of(hair, state), points_of(hair, good)
    np.testing.assert_array_equal(points[[0, 2]], others[[0, 2]])
    assert np.abs(points[1] - others[1]).max() > 1e-6
    assert stretch(points) < (1.01 if held else 1.2)


def test_a_strand_that_cannot_be_solved_leaves_the_volume_to_the_others(strands, triangle):
    """On the grid its speed would be that of its neighbours: it is held before anything is put there."""
    hair, body = strands(9, apart=2e-3), triangle()
    shot = Scene(steps=STEPS, volume=Volume(friction=60.0))
    good, _ = thrown(hair, body, shot, 0.0, 4)
    state, reported = thrown(hair, body, shot, 1e200, 4)
    assert [each for each in reported if "1 of 9 strands had no solution in 1 of 10 steps" in each]
    points = points_of(hair, state)
    assert stretch(points) < 1.01
    off = np.abs(points - points_of(hair, good)).max(axis=(1, 2))
    assert off[4] < 0.05 * LENGTH and np.delete(off, 4).max() < 0.01 * LENGTH


def test_a_guide_that_cannot_be_solved_keeps_its_lock(strands, triangle):
    """It is named by its own id, its followers go with it, and what is in no lock does not notice."""
    hair, body = strands(4, "network", apart=3e-4), triangle()
    shot = Scene(steps=STEPS, stiction=Stiction(), locks=Locks(after=1, tolerance=0.01, audit=0.0))
    state = None
    for _ in range(4):
        state = next_state(hair, state, Frame((body, body), (), (), 0.0, FRAME), shot)
    leaders = state.leaders(4)
    guide = int(leaders[leaders != np.arange(4)][0])
    good, _ = thrown(hair, body, shot, 0.0, guide, state)
    after, reported = thrown(hair, body, shot, 1e200, guide, state)
    assert [each for each in reported if UNSOLVED in each and f"strands {guide} " in each]
    points = points_of(hair, after)
    assert stretch(points) < 1.02
    assert np.abs(points - points_of(hair, good)).max() < 0.1 * LENGTH
    np.testing.assert_array_equal(after.leaders(4) == guide, good.leaders(4) == guide)
