"""Whatever points do to where a step ends, no crossing is missed among the candidates."""

import numpy as np
import pytest

from hairpipe.contact import collision as module
from hairpipe.contact.collision import Candidates, crossings, touched_by
from hairpipe.geometry.segments import key_of

from ...segment_scenes import every_pair

ROUNDS = 8


@pytest.fixture
def listed(monkeypatch):
    """Count how often all pairs are listed, and those of how many segments."""
    counts = {"all": 0, "some": []}

    def all_pairs(*arguments):
        counts["all"] += 1
        return swept_pairs(*arguments)

    def some_pairs(around, segments, *arguments):
        counts["some"].append(len(segments))
        return swept_pairs_of(around, segments, *arguments)

    swept_pairs, swept_pairs_of = module.swept_pairs, module.swept_pairs_of
    monkeypatch.setattr(module, "swept_pairs", all_pairs)
    monkeypatch.setattr(module, "swept_pairs_of", some_pairs)
    return counts


def assert_none_is_missed(candidates, before, ends, every):
    found = key_of(candidates.of(np.ones(len(before), bool)))
    assert len(np.unique(found)) == len(found)
    met = key_of(crossings(before, ends, every).segments)
    assert len(met) and np.isin(met, found).all()


def wander(points, part, far, rng):
    """Move some of the points, about so far."""
    moves = far * rng.normal(size=points.shape)
    return points + moves * (rng.random((len(points), 1)) < part)


@pytest.mark.parametrize(
    ("part", "far", "ways"),
    [(0.01, 0.1, ""), (0.01, 1.0, "some"), (0.05, 10.0, "all some"), (1.0, 0.1, "all some"), (1.0, 3.0, "all")],
)
def test_none_is_missed_while_ends_change(part, far, ways, listed):
    """Of points that leave where they are by about so many reaches, and of those that come back."""
    rng = np.random.default_rng(11)
    reach, offsets = 0.02, np.arange(41, dtype=np.int32) * 8
    before = (0.05 * rng.normal(size=(40, 8, 3)).cumsum(axis=1) + rng.random((40, 1, 3))).reshape(-1, 3)
    after = before + 0.1 * rng.normal(size=before.shape)
    every = np.stack(every_pair(offsets), axis=1).astype(np.int32)
    candidates, ends = Candidates(before, after, offsets, reach, None), after
    for turn in range(ROUNDS):
        ends = after if turn == ROUNDS - 2 else wander(ends, part, far * reach, rng)
        candidates.renew(ends)
        assert_none_is_missed(candidates, before, ends, every)
        marked = rng.random(len(before)) < 0.1
        touched = touched_by(marked, offsets)
        of = candidates.of(marked)
        listed_now = candidates.of(np.ones(len(before), bool))
        expected = listed_now[touched[listed_now].any(axis=1)]
        np.testing.assert_array_equal(of, expected)
    assert (listed["all"] > 1) == ("all" in ways) and bool(listed["some"]) == ("some" in ways)


def test_nothing_is_listed_again_for_small_moves(listed):
    rng = np.random.default_rng(2)
    offsets = np.arange(21, dtype=np.int32) * 8
    before = rng.random((160, 3))
    after = before + 0.2 * rng.normal(size=before.shape)
    candidates = Candidates(before, after, offsets, 0.1, None)
    for _ in range(ROUNDS):
        moves = rng.normal(size=after.shape)
        candidates.renew(after + 0.0499 * moves / np.linalg.norm(moves, axis=1)[:, None])
    assert listed == {"all": 1, "some": []}


def test_points_are_in_the_segments_they_bound():
    marked = np.array([False, True, False, False, True, False, True])
    assert touched_by(marked, np.array([0, 3, 7], np.int32)).tolist() == [True, True, False, True, True, True, False]


def test_an_end_that_continues_by_half_the_reach_is_not_lost():
    """One end leaves, the other goes to and fro within half the reach, and so does what they may meet."""
    offsets = np.arange(33, dtype=np.int32) * 2
    before = np.repeat(100.0 * np.arange(1, 33)[:, None] * [1.0, 0.0, 0.0], 2, axis=0)
    before[1::2] += [0.0, 10.0, 0.0]
    before[0], before[1] = [-5.0, 0.0, 0.0], [5.0, 0.0, 0.0]
    before[2], before[3] = [4.9, -5.0, 3.0], [4.9, 5.0, 3.0]
    after = before.copy()
    after[2:4, 2] = 0.97
    candidates, ends = Candidates(before, after, offsets, 1.0, None), after.copy()
    for here, there in ((-0.49, 0.97), (0.49, 0.48)):
        ends[0], ends[1], ends[2:4, 2] = [-5.6, 0.0, 0.0], [5.0, 0.0, here], there
        candidates.renew(ends)
    assert np.array_equal(crossings(before, ends, np.array([[0, 2]], np.int32)).segments, [[0, 2]])
    assert [0, 2] in candidates.of(np.ones(len(before), bool)).tolist()
