"""Sets of pairs against those of numpy, also in several parts."""

import numpy as np
import pytest

from hairpipe.contact.hair import intersection, union


@pytest.mark.parametrize(("few", "many"), [(0, 0), (0, 5), (7, 90), (40_000, 90_000)])
def test_union_and_intersection_are_those_of_sets(few, many):
    rng = np.random.default_rng(few)
    a, b = (np.unique(rng.integers(0, 2 * many + 1, count)) for count in (few, many))
    apart = a[~np.isin(a, b)]
    for one, other in ((a, b), (b, a), (apart, b)):
        np.testing.assert_array_equal(union(one, other), np.union1d(one, other))
        np.testing.assert_array_equal(intersection(one, other), np.intersect1d(one, other))
