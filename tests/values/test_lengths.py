"""Lengths of strands, one at a time and all together."""

from itertools import pairwise

import numpy as np
import pytest

from hairpipe.values.groom import segment_lengths, strand_lengths


def test_lengths_against_one_strand_at_a_time() -> None:
    rng = np.random.default_rng(3)
    offsets = np.cumsum([0, 2, 5, 3, 9]).astype(np.int32)
    points = rng.normal(size=(offsets[-1], 3))
    pieces = [points[a:b] for a, b in pairwise(offsets)]
    expected = [sum(np.linalg.norm(b - a) for a, b in pairwise(p)) for p in pieces]
    assert strand_lengths(points, offsets) == pytest.approx(expected)
    assert segment_lengths(points, offsets).sum() == pytest.approx(sum(expected))
    assert len(segment_lengths(points, offsets)) == offsets[-1] - 4


def test_a_lost_strand_does_not_spoil_the_lengths_of_the_others() -> None:
    points = np.zeros((6, 3))
    points[[1, 3, 5], 0] = 0.2, 1e30, 0.2
    assert strand_lengths(points, np.array([0, 2, 4, 6]))[[0, 2]] == pytest.approx([0.2, 0.2])
