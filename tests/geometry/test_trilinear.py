"""Laws of splat and sample."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.trilinear import sample, splat, voxel_at

POINTS = np.random.default_rng(0).uniform(0.0, [4.0, 3.0, 5.0], (50, 3))
SHAPE = 5, 4, 6


@njit
def splat_all(grid: np.ndarray, points: np.ndarray, amounts: np.ndarray) -> None:
    for p in range(len(points)):
        splat(grid, voxel_at(grid, points[p, 0], points[p, 1], points[p, 2]), amounts[p])


@njit
def sample_all(grid: np.ndarray, points: np.ndarray) -> np.ndarray:
    values = np.empty(len(points))
    for p in range(len(points)):
        values[p] = sample(grid, voxel_at(grid, points[p, 0], points[p, 1], points[p, 2]))
    return values


def test_a_linear_field_is_sampled_exactly_within_the_grid_and_at_its_border_beyond():
    x, y, z = np.indices(SHAPE)
    grid = 1.0 + 2.0 * x - y + 0.5 * z
    assert sample_all(grid, POINTS) == pytest.approx(1.0 + POINTS @ [2.0, -1.0, 0.5])
    beyond = np.array([[9.0, 1.5, 2.0], [-3.0, 1.5, 2.0], [4.0, 3.0, 5.0], [np.nan, 0.0, 0.0]])
    assert sample_all(grid, beyond) == pytest.approx([8.5, 0.5, 8.5, 1.0])


def test_splat_is_the_transpose_of_sample():
    rng = np.random.default_rng(1)
    amounts, field, grid = rng.normal(size=50), rng.normal(size=SHAPE), np.zeros(SHAPE)
    splat_all(grid, POINTS, amounts)
    assert grid.sum() == pytest.approx(amounts.sum())
    assert np.sum(grid * field) == pytest.approx(amounts @ sample_all(field, POINTS))
