"""Quadratic B-splines on a grid: sums, moments, and slopes against finite differences."""

import numpy as np
import pytest

from hairpipe.values.groom import reach_of
from hairpipe.volume.targeting import add_slopes, weigh
from hairpipe.volume.transfer import sample_strands

CELL = 0.01


@pytest.fixture
def strands():
    """Thirty strands of twelve points, whose segments stay clear of a multiple of the cell."""
    rng = np.random.default_rng(5)
    steps = rng.normal(size=(30, 11, 3))
    steps *= rng.uniform(0.3, 0.9, (30, 11, 1)) * CELL / np.linalg.norm(steps, axis=2, keepdims=True)
    roots = rng.normal(0.0, 0.03, (30, 1, 3))
    points = np.concatenate([roots, roots + np.cumsum(steps, axis=1)], axis=1).reshape(-1, 3)
    return points, (np.arange(31) * 12).astype(np.int32), rng.uniform(0.5, 1.5, len(points))


def nodes_of(samples):
    counts = samples.counts + 2
    return CELL * (np.stack(np.indices(counts), axis=3) + samples.low - 1)


def test_weights_sum_up_and_lie_where_hair_is(strands):
    """The first moment is exact, too: splines reproduce what is linear."""
    points, offsets, amounts = strands
    samples = sample_strands(points, offsets, reach_of(points, offsets), CELL)
    grid = weigh(samples, amounts)
    assert grid.sum() == pytest.approx(amounts.sum(), rel=1e-13)
    shares = amounts / samples.sums
    ends = np.delete(np.arange(len(points)), offsets[1:] - 1)
    own = 0.5 * (shares[ends] + shares[ends + 1])
    moments = own[:, None] * 0.5 * (points[ends] + points[ends + 1])  # a piece a segment, half way
    np.testing.assert_allclose(np.einsum("ijk,ijkc->c", grid, nodes_of(samples)), moments.sum(axis=0), rtol=1e-12)


def test_slopes_are_those_of_the_sum(strands):
    points, offsets, amounts = strands
    reach = 10.0 * np.ones(len(offsets) - 1)
    samples = sample_strands(points, offsets, reach, CELL)
    field = np.random.default_rng(6).normal(size=samples.counts + 2)
    found = np.zeros_like(points)
    add_slopes(samples, amounts / samples.sums, field, found)
    inner = np.argsort(np.abs(points - points.mean(axis=0)).max(axis=1))[:20]  # moved without changing the box
    for at in inner:
        for c in range(3):
            ahead, behind = points.copy(), points.copy()
            ahead[at, c] += 1e-6
            behind[at, c] -= 1e-6
            one, other = (
                np.sum(field * weigh(sample_strands(moved, offsets, reach, CELL), amounts)) for moved in (ahead, behind)
            )
            assert found[at, c] == pytest.approx((one - other) / 2e-6, abs=1e-6 * np.abs(found).max())
