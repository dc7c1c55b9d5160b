"""What a machine can do."""

import numpy as np
import pytest

from hairpipe.geometry.simd import width
from hairpipe.graphs.experiments.bench import roofs
from hairpipe.graphs.experiments.bench.arithmetic.assembly import assembly_of, count_arithmetic


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_the_chains_converge_to_what_they_iterate(dtype):
    """y = y / 2 + 1 goes to 2; four chains are added to each of two sums."""
    start = np.zeros((roofs.CHAINS, width(dtype)), dtype)
    roofs._chain(start, 0.5, 1.0, 200)
    np.testing.assert_allclose(start[:2], 8.0, rtol=1e-6)


def test_all_of_the_chains_are_vectors():
    code = count_arithmetic(assembly_of(roofs._chain, np.zeros((8, 8)), 0.5, 1.0, 10).splitlines())
    assert code.packed == 1.0 and sum(code) >= roofs.CHAINS


def test_rates_are_those_of_a_machine():
    """A processor of our time does at least 1e8 multiply-adds and moves 1e8 bytes a second, and at most 1e13."""
    found = roofs.measure_roofs(["float64"], [1], 1 << 16, 0.0)
    rates = [found.multiply_add["float64"].median, found.triad[1].median]
    assert all(1e8 < rate < 1e13 for rate in rates)
