"""Compaction against numpy, of lengths around those of chunks."""

import numpy as np
import pytest

from hairpipe.geometry.sorting import places_of, rows_at, runs_of


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
