"""Keys sorted by some of their bits keep their order where these are equal."""

import numpy as np
import pytest

from hairpipe.geometry.sorting import sorted_by_bits


@pytest.mark.parametrize("count", [0, 1, 1000, 100_000])
@pytest.mark.parametrize(("low", "high"), [(0, 7), (5, 30), (32, 53)])
def test_order_is_that_of_a_stable_sort(count, low, high):
    keys = np.random.default_rng(count).integers(0, 2**62, count)
    order = np.argsort(keys >> low & (1 << (high - low)) - 1, kind="stable")
    np.testing.assert_array_equal(sorted_by_bits(keys, low, high), keys[order])
