"""Mass and momentum on a grid, and back, and quadratic splines on it."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.values.groom import reach_of
from hairpipe.volume.targeting import add_slopes, weigh
from hairpipe.volume.transfer import collect, deposit, mean_velocities, sample_strands
from hairpipe.volume.volume_filter import smooth

CELL = 0.006


class Hair:
    """Strands of several lengths and segments in a ball of 15 cm, with masses and velocities of any kind."""

    def __init__(self, seed, strands=300):
        self.rng = rng = np.random.default_rng(seed)
        counts = rng.integers(2, 30, strands)
        self.offsets = np.concatenate(([0], np.cumsum(counts))).astype(np.int32)
        steps = rng.normal(0.0, 0.004, (self.offsets[-1], 3))
        steps[self.offsets[:-1]] = rng.normal(0.0, 0.05, (strands, 3))
        walked = np.cumsum(steps, axis=0)
        self.points = walked - np.repeat((walked - steps)[self.offsets[:-1]], counts, axis=0)
        self.masses = rng.uniform(1e-7, 1e-6, len(self.points))
        self.velocities = rng.normal(0.3, 1.0, self.points.shape)

    def samples(self, cell=CELL):
        return sample_strands(self.points, self.offsets, np.full(len(self.offsets) - 1, 1.0), cell)


def grid_of(hair, passes=0, nu=1 / 6):
    grid = deposit(hair.samples(), hair.masses, hair.velocities)
    before, after = np.empty((*grid.shape[:3], 3)), np.empty((*grid.shape[:3], 3))
    mean_velocities(grid, before)
    for _ in range(passes):
        smooth(grid, before, nu, after)
        before, after = after, before
    return grid, before


@pytest.mark.parametrize("passes", [0, 1, 4])
def test_momentum_is_the_same_on_the_grid_and_back(passes):
    hair = Hair(passes)
    grid, smoothed = grid_of(hair, passes)
    scale = np.sum(hair.masses[:, None] * np.abs(hair.velocities))
    momentum = hair.masses @ hair.velocities
    assert grid[..., 0].sum() == pytest.approx(hair.masses.sum(), rel=1e-12)
    assert grid[..., 1:].sum(axis=(0, 1, 2)) == pytest.approx(momentum, abs=1e-12 * scale)
    assert np.sum(grid[..., :1] * smoothed, axis=(0, 1, 2)) == pytest.approx(momentum, abs=1e-12 * scale)
    assert hair.masses @ collect(hair.samples(), smoothed) == pytest.approx(momentum, abs=1e-12 * scale)


def test_collecting_is_the_transpose_of_splatting():
    """sum_g field_g P2G(v)_g = sum_i m_i v_i G2P(field)_i, for any field."""
    hair = Hair(7)
    grid = deposit(hair.samples(), hair.masses, hair.velocities)
    field = hair.rng.normal(size=(*grid.shape[:3], 3))
    there = np.sum(field * grid[..., 1:])
    back = np.sum(hair.masses[:, None] * hair.velocities * collect(hair.samples(), field))
    assert there == pytest.approx(back, rel=1e-11)


def test_hair_that_moves_as_one_is_left_alone():
    hair = Hair(3)
    hair.velocities[:] = [0.3, -2.0, 1.0]
    _, smoothed = grid_of(hair, 2)
    assert collect(hair.samples(), smoothed) == pytest.approx(hair.velocities, rel=1e-12)


def test_the_grid_is_the_same_on_any_number_of_threads(same_on_threads):
    hair = Hair(5, 900)
    same_on_threads(lambda: grid_of(hair, 1)[1])


def test_samples_leave_no_holes_along_segments_longer_than_cells():
    points = np.array([[0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.1, 0.0, 0.0]])
    samples = sample_strands(points, np.array([0, 3], np.int32), np.ones(1), 0.005)
    grid = deposit(samples, np.array([0.5, 1.0, 0.5]), np.zeros((3, 3)))
    along = grid[..., 0].sum(axis=(1, 2))
    assert along[1:-2] == pytest.approx(2.0 / 20, rel=0.1)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, 1e9])
def test_a_lost_strand_is_omitted_and_makes_no_grid_huge(wrong):
    hair = Hair(11)
    whole = hair.samples()
    last = hair.offsets[5] - 1
    hair.points[last, 1] = wrong
    samples = hair.samples()
    lost = slice(hair.offsets[4], hair.offsets[5])
    assert np.prod(samples.counts) <= np.prod(whole.counts)
    assert not samples.sums[lost].any() and np.delete(samples.sums, np.r_[lost]).all()


def test_hair_that_is_all_lost_has_no_grid():
    points = np.full((4, 3), np.nan)
    assert sample_strands(points, np.array([0, 4], np.int32), np.ones(1), 0.01) is None


def test_cells_that_make_the_grid_too_large_are_refused_with_cells_that_do_not():
    hair = Hair(2)
    with pytest.raises(BadInput, match=r"volume\.cell.*nodes.*at least") as refused:
        hair.samples(2e-4)
    fits = float(str(refused.value).rsplit("at least ", 1)[1].split(" m")[0])
    assert hair.samples(fits) is not None


WIDE = 0.01


@pytest.fixture
def strands():
    """Thirty strands of twelve points, whose segments stay clear of a multiple of the cell."""
    rng = np.random.default_rng(5)
    steps = rng.normal(size=(30, 11, 3))
    steps *= rng.uniform(0.3, 0.9, (30, 11, 1)) * WIDE / np.linalg.norm(steps, axis=2, keepdims=True)
    roots = rng.normal(0.0, 0.03, (30, 1, 3))
    points = np.concatenate([roots, roots + np.cumsum(steps, axis=1)], axis=1).reshape(-1, 3)
    return points, (np.arange(31) * 12).astype(np.int32), rng.uniform(0.5, 1.5, len(points))


def nodes_of(samples):
    counts = samples.counts + 2
    return WIDE * (np.stack(np.indices(counts), axis=3) + samples.low - 1)


def test_weights_sum_up_and_lie_where_hair_is(strands):
    """The first moment is exact, too: splines reproduce what is linear."""
    points, offsets, amounts = strands
    samples = sample_strands(points, offsets, reach_of(points, offsets), WIDE)
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
    samples = sample_strands(points, offsets, reach, WIDE)
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
                np.sum(field * weigh(sample_strands(moved, offsets, reach, WIDE), amounts)) for moved in (ahead, behind)
            )
            assert found[at, c] == pytest.approx((one - other) / 2e-6, abs=1e-6 * np.abs(found).max())
