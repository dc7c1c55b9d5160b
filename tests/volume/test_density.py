"""Density of hair: all of it is on the grid, where it is."""

import numpy as np
import pytest
from numba import get_num_threads, set_num_threads

from hairpipe.graphs.experiments.chart.sections import section_of
from hairpipe.values import Strands
from hairpipe.values.groom import strand_lengths
from hairpipe.volume.density import density_of

CELL = 0.01


def hair_of(points, velocities=None):
    """Strands of points, (S, n, 3)."""
    flat = np.asarray(points, float).reshape(-1, 3)
    offsets = (np.arange(len(points) + 1) * len(points[0])).astype(np.int32)
    speeds = np.zeros(flat.shape) if velocities is None else velocities
    return Strands(flat, np.asarray(speeds, np.float32), offsets, 8e-5)


@pytest.fixture
def random_hair():
    rng = np.random.default_rng(8)
    return hair_of(np.cumsum(0.004 * rng.normal(size=(50, 12, 3)), axis=1), rng.normal(size=(600, 3)))


def test_all_hair_is_on_the_grid_and_moves_there(random_hair):
    density, points = density_of(random_hair, CELL), random_hair.points.astype(float)
    lengths = strand_lengths(points, random_hair.offsets)
    assert density.length.sum(dtype=float) * CELL**3 == pytest.approx(lengths.sum(), rel=1e-7)
    momentum = (density.length[..., None] * density.velocity.astype(float)).sum(axis=(0, 1, 2)) * CELL**3
    steps = np.linalg.norm(np.diff(points.reshape(50, 12, 3), axis=1), axis=2)
    shares = 0.5 * (np.pad(steps, ((0, 0), (1, 0))) + np.pad(steps, ((0, 0), (0, 1))))
    np.testing.assert_allclose(momentum, shares.ravel() @ random_hair.velocities, atol=1e-5 * np.abs(momentum).max())


def test_hair_moved_by_cells_has_its_density_moved(random_hair):
    by, cell = np.array([3, -2, 7]), 2.0**-7
    points = np.round(random_hair.points * 2**24) / 2**24  # so that shifts are exact
    here, there = (
        density_of(Strands(moved, random_hair.velocities, random_hair.offsets, 8e-5), cell)
        for moved in (points, points + by * cell)
    )
    np.testing.assert_array_equal(there.low, here.low + by)
    assert there.length.shape == here.length.shape
    assert there.length.tobytes() == here.length.tobytes() and there.velocity.tobytes() == here.velocity.tobytes()


def test_it_is_the_same_on_any_number_of_threads(random_hair):
    threads, found = get_num_threads(), []
    try:
        for count in (1, min(2, threads)):
            set_num_threads(count)
            found.append(density_of(random_hair, CELL))
    finally:
        set_num_threads(threads)
    assert found[0].length.tobytes() == found[1].length.tobytes()
    assert found[0].velocity.tobytes() == found[1].velocity.tobytes()


def test_no_straight_hair_is_lost_by_rounding():
    """From root to tip a straight hair may be longer than along its segments, in the last bit."""
    towards = np.random.default_rng(1).normal(size=(200, 3))
    towards *= 0.2 / np.linalg.norm(towards, axis=1, keepdims=True)
    density = density_of(hair_of(np.linspace(0.0, 1.0, 21)[None, :, None] * towards[:, None]), CELL)
    assert density.length.sum(dtype=float) * CELL**3 == pytest.approx(200 * 0.2, rel=1e-7)


def test_the_middle_of_an_even_bundle_has_one_hair_for_each_square(random_hair):
    """Parallel hairs a millimetre apart: 1e6 metres in a cubic metre."""
    x, z = np.meshgrid(np.arange(40) * 1e-3, np.arange(40) * 1e-3)
    roots = np.stack([x.ravel(), 0 * x.ravel(), z.ravel()], axis=1)
    hair = hair_of(roots[:, None] + np.linspace(0.0, -0.1, 21)[None, :, None] * np.array([0.0, 1.0, 0.0]))
    section, extent = section_of(density_of(hair, CELL), 1, -0.05)
    assert section[2, 2] == pytest.approx(1e6, rel=1e-4)
    assert extent[0] <= 0.0 and extent[1] >= 0.039
    assert not section_of(density_of(hair, CELL), 1, 0.5)[0].any()


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_hair_that_is_not_finite_is_omitted(random_hair, wrong):
    points = random_hair.points.copy()
    points[5, 1] = wrong
    rest = Strands(points[12:], random_hair.velocities[12:], random_hair.offsets[:-1], 8e-5)
    with_it = density_of(Strands(points, random_hair.velocities, random_hair.offsets, 8e-5), CELL)
    np.testing.assert_array_equal(with_it.length, density_of(rest, CELL).length)
    nothing = density_of(Strands(points[:12], random_hair.velocities[:12], random_hair.offsets[:2], 8e-5), CELL)
    assert nothing.length.size == 0
    assert section_of(nothing, 0, 0.0)[0].size == 0
