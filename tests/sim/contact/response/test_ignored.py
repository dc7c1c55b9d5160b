"""Sets of pairs against Python's own."""

import numpy as np

from hairpipe.sim.contact.ignored import keys_of, without
from hairpipe.sim.contact.pairs import Pairs


def random_segments(count, seed):
    """Pairs of segments, with numbers up to the largest there can be."""
    rng = np.random.default_rng(seed)
    both = rng.integers(0, 40, (count, 2)).astype(np.int32)
    both[both > 30] += 2**31 - 41
    both = np.sort(both, axis=1)
    return both[both[:, 0] < both[:, 1]]


def test_what_is_in_the_set_is_taken_out_and_nothing_else():
    segments, others = np.unique(random_segments(900, 0), axis=0), random_segments(500, 1)
    rows = np.arange(len(segments))
    pairs = Pairs(segments, np.stack([rows, rows], 1) * 1.0, rows * 1.0)
    left = without(pairs, keys_of(others))
    names = set(map(tuple, others.tolist()))
    expected = [row for row, pair in enumerate(segments.tolist()) if tuple(pair) not in names]
    assert 0 < len(expected) < len(segments)
    np.testing.assert_array_equal(left.distances, expected)
    np.testing.assert_array_equal(left.segments, segments[expected])
    np.testing.assert_array_equal(left.fractions, pairs.fractions[expected])


def test_an_empty_set_takes_nothing_out():
    pairs = Pairs(np.array([[0, 2]], np.int32), np.zeros((1, 2)), np.zeros(1))
    assert without(pairs, keys_of(np.empty((0, 2), np.int32))) is pairs
