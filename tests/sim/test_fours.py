"""Four numbers in a register against numpy."""

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from hairpipe.sim.fours import item, load_four, symmetric_times, zeros


@njit
def _multiply(numbers, v, out):
    result = zeros() + symmetric_times(load_four(numbers, 1), load_four(numbers, 5), load_four(v, 2))
    result = result + item(load_four(numbers, 1), 3) * load_four(v, 2) - zeros()
    for place in range(3):
        out[place] = item(result, place)


def test_it_multiplies_by_a_symmetric_matrix_and_by_a_number():
    rng = np.random.default_rng(0)
    numbers, v, out = rng.normal(size=9).astype(np.float32), rng.normal(size=6).astype(np.float32), np.empty(3)
    xx, xy, xz, s, yy, yz, zz = numbers[1:8].astype(float)
    M = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    _multiply(numbers, v, out)
    np.testing.assert_allclose(out, M @ v[2:5] + s * v[2:5], rtol=1e-5)


def test_it_loads_from_single_precision_only():
    with pytest.raises(TypingError, match="float32"):
        _multiply(np.ones(9), np.ones(6, np.float32), np.empty(3))
