"""Compaction, Morton order and radix sort against numpy."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from hairpipe.geometry.sorting import morton_order, morton_order_in_cube, places_of, rows_at, runs_of, sorted_by_bits


@pytest.mark.parametrize("count", [0, 1, 4095, 4096, 4097, 20_000])
def test_places_and_rows_are_those_of_numpy(count):
    rng = np.random.default_rng(count)
    rows = rng.random((count, 3))
    for part in (0.0, 0.3, 1.0):
        marks = rng.random(count) < part
        places = places_of(marks)
        np.testing.assert_array_equal(places, np.flatnonzero(marks))
        np.testing.assert_array_equal(rows_at(rows, places), rows[marks])
        np.testing.assert_array_equal(rows_at(rows[:, 0].copy(), places), rows[marks, 0])


@pytest.mark.parametrize("count", [0, 1, 900])
def test_runs_begin_where_a_search_finds_them(count):
    numbers = np.sort(np.random.default_rng(3).integers(0, 300, count))
    starts = runs_of(numbers << 32 | np.arange(count), 310)
    np.testing.assert_array_equal(starts, np.searchsorted(numbers, np.arange(311)))


def test_it_is_an_order_and_follows_octants():
    points = np.random.default_rng(0).random((5000, 3))
    order = morton_order(points)
    assert np.array_equal(np.sort(order), np.arange(5000))
    low, high = points.min(axis=0), np.ptp(points, axis=0).max()
    octants = (((points - low) / high >= 0.5) * [1, 2, 4]).sum(axis=1)
    assert np.all(np.diff(octants[order]) >= 0)


def test_neighbours_in_space_are_near_in_the_order():
    points = np.random.default_rng(1).random((4096, 3)) * [1.0, 1.0, 0.0]
    place = np.argsort(morton_order(points))
    closest = cKDTree(points).query(points, 2)[1][:, 1]
    assert np.median(np.abs(place - place[closest])) <= 4


def test_none_one_and_many_in_one_place():
    assert len(morton_order(np.empty((0, 3)))) == 0
    assert morton_order(np.ones((1, 3))).tolist() == [0]
    assert morton_order(np.ones((4, 3))).tolist() == [0, 1, 2, 3]


def test_the_order_in_a_given_cube_is_the_same_curve_with_the_axes_reversed():
    cells = np.stack(np.meshgrid(*[np.arange(8)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) + 0.5
    cells = np.random.default_rng(2).permutation(cells)
    in_cube = morton_order_in_cube(cells, np.full(3, 4.0), 4.0)
    assert np.array_equal(cells[in_cube], cells[morton_order(cells[:, ::-1])])


def test_points_outside_the_cube_and_in_one_cell_keep_their_order():
    assert morton_order_in_cube(np.full((5, 3), 9.0), np.zeros(3), 1.0).tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("count", [0, 1, 1000, 100_000])
@pytest.mark.parametrize(("low", "high"), [(0, 7), (5, 30), (32, 53)])
def test_order_is_that_of_a_stable_sort(count, low, high):
    keys = np.random.default_rng(count).integers(0, 2**62, count)
    order = np.argsort(keys >> low & (1 << (high - low)) - 1, kind="stable")
    np.testing.assert_array_equal(sorted_by_bits(keys, low, high), keys[order])
