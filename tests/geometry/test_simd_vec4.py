"""Four numbers in a register against numpy."""

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from hairpipe.geometry.simd_vec4 import (
    WHOLE,
    dot,
    dot_in_all,
    item,
    last_in_all,
    load_four,
    load_short_four,
    store_four,
    zeros,
)


@njit
def _project(parts, v, out):
    d, v = load_short_four(parts, 1), load_four(v, 2)
    result = zeros() + dot(d, v) * d - item(d, 3) * v
    for place in range(3):
        out[place] = item(result, place)


def test_it_multiplies_vectors_and_numbers():
    rng = np.random.default_rng(0)
    parts, v, out = np.int16([7, -32767, 32767, 4711, 16384]), rng.normal(size=6).astype(np.float32), np.empty(3)
    d, s = parts[1:4] / WHOLE, parts[4] / WHOLE
    _project(parts, v, out)
    np.testing.assert_allclose(out, d * (d @ v[2:5]) - s * v[2:5], rtol=1e-5)


@njit
def _spread(v, out):
    four = load_four(v, 1)
    store_four(out, 0, dot_in_all(four, load_four(v, 2)))
    store_four(out, 5, last_in_all(four))


def test_a_sum_and_the_last_number_are_in_all_four_and_are_written_where_they_belong():
    v, out = np.arange(1, 7, dtype=np.float32), np.full(10, -1.0, np.float32)
    _spread(v, out)
    assert out.tolist() == [*[2.0 * 3 + 3 * 4 + 4 * 5 + 5 * 6] * 4, -1.0, *[5.0] * 4, -1.0]


def test_it_loads_the_right_precision_only():
    with pytest.raises(TypingError, match="float32"):
        _project(np.zeros(5, np.int16), np.ones(6), np.empty(3))
    with pytest.raises(TypingError, match="int16"):
        _project(np.zeros(5, np.int32), np.ones(6, np.float32), np.empty(3))
