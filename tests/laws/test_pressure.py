"""Pressure on a grid: hair that is too dense spreads, and nothing else happens to it."""

import numpy as np
import pytest

from hairpipe.laws.pressure import MOST_RATE, densest, spread

CELL, REST, DT = 0.01, 10.0, 1 / 96


def ball(density, seed=0):
    """A ball of hair, denser in the middle, in velocities of any kind."""
    rng, place = np.random.default_rng(seed), np.stack(np.meshgrid(*[np.arange(14.0)] * 3, indexing="ij"), axis=-1)
    radius = np.linalg.norm(place - 6.5, axis=-1)
    mass = np.where(radius < 5.5, density * CELL**3 * np.maximum(2.0 - radius / 4.0, 0.1), 0.0)
    grid = np.concatenate((mass[..., None], np.zeros((*mass.shape, 3))), axis=-1)
    return grid, np.where(mass[..., None] > 0.0, rng.normal(0.0, 0.1, (*mass.shape, 3)), 0.0)


def divergence(velocities):
    """Of all cells, from the differences between opposite faces."""
    total = 0.0
    for axis in range(3):
        faces = np.diff(velocities[..., axis], axis=axis)
        for other in (a for a in range(3) if a != axis):
            faces = 0.5 * (np.take(faces, range(1, 14), other) + np.take(faces, range(13), other))
        total = total + faces / CELL
    return total


def densities(grid):
    mass = grid[..., 0]
    for axis in range(3):
        mass = 0.5 * (np.take(mass, range(1, 14), axis) + np.take(mass, range(13), axis))
    return mass / CELL**3


@pytest.mark.parametrize("compliance", [0.0, 0.1])
def test_pressure_keeps_momentum(compliance):
    grid, velocities = ball(1.5 * REST)
    pressed = velocities.copy()
    spread(grid, pressed, CELL, REST, compliance, DT)
    change = grid[..., :1] * (pressed - velocities)
    assert np.abs(change).sum() > 0.0
    assert change.sum(axis=(0, 1, 2)) == pytest.approx(0.0, abs=1e-12 * np.abs(change).sum())


def test_dense_cells_expand():
    grid, velocities = ball(1.5 * REST)
    spread(grid, velocities, CELL, REST, 0.0, DT)
    dense = densities(grid) > 1.5 * REST
    assert dense.any()
    rates = divergence(velocities)[dense]
    assert rates.min() > 0.8 * MOST_RATE and rates.mean() < 1.1 * MOST_RATE


def test_thin_hair_feels_nothing():
    grid, velocities = ball(0.3 * REST)
    pressed = 0.01 * velocities
    spread(grid, pressed, CELL, REST, 0.1, DT)
    assert np.array_equal(pressed, 0.01 * velocities)


def test_pressure_never_pulls():
    """Hair that flies apart goes on as it was."""
    grid, velocities = ball(1.2 * REST)
    velocities[:] = 20.0 * CELL * (np.stack(np.meshgrid(*[np.arange(14.0)] * 3, indexing="ij"), axis=-1) - 6.5)
    pressed = np.where(grid[..., :1] > 0.0, velocities, 0.0)
    before = pressed.copy()
    spread(grid, pressed, CELL, REST, 0.1, DT)
    assert np.array_equal(pressed, before)


def test_the_densest_cell_is_one_with_hair_at_all_corners():
    grid, _ = ball(1.5 * REST)
    filled = np.lib.stride_tricks.sliding_window_view(grid[..., 0] > 0.0, (2, 2, 2)).all(axis=(-3, -2, -1))
    assert densest(grid, CELL) == pytest.approx(densities(grid)[filled].max())
    grid[..., 0] = np.where(np.arange(14) % 2, grid[..., 0], 0.0)
    assert densest(grid, CELL) == 0.0
