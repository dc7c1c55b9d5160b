"""Pairs and densities are those of brute force."""

import numpy as np
import pytest

from hairpipe.particles.interaction import find_pairs
from hairpipe.particles.model import kernel


@pytest.mark.parametrize("spread", [(1.0, 1.0, 1.0), (10.0, 0.01, 1.0), (1e3, 1e3, 1e3)])
def test_all_pairs_are_found_once(spread):
    points = np.random.default_rng(0).normal(size=(400, 3)) * spread
    points[7:20] = points[7]
    points[20:24] = 1e5 * spread[0] + 0.01 * points[20:24]
    h = 0.15
    masses = np.linspace(1.0, 2.0, 400)
    found = find_pairs(masses, points, h)
    pairs = found.ends
    distances = np.linalg.norm(points[:, None] - points, axis=2)
    expected = np.argwhere(np.triu(distances < 2.0 * h, 1))
    assert sorted(map(tuple, np.sort(pairs, axis=1).tolist())) == sorted(map(tuple, expected.tolist()))
    assert found.apart == pytest.approx(distances[tuple(pairs.T)])
    assert found.density == pytest.approx(kernel(distances, h) @ masses)
    for k in (0, 7, 399):
        assert sorted(found.by[found.rows[k] : found.rows[k + 1]]) == sorted(np.flatnonzero((pairs == k).any(axis=1)))
