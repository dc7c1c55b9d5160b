"""Lanes compute what as many separate numbers would, in single and in double precision."""

import os
import pickle
import subprocess
import sys

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from hairpipe.geometry import simd_vec4
from hairpipe.geometry.compile import Inlined, inlined
from hairpipe.geometry.simd import (
    WIDTH,
    any_lane,
    bits,
    either,
    load,
    lowest,
    maximum,
    minimum,
    multiply_add,
    select,
    sqrt,
    store,
    width,
)

KINDS = pytest.mark.parametrize("dtype", [np.float32, np.float64])


@njit
def _everything(a, b, numbers, out):
    x, y = load(a, (0,)), load(b, (0,))
    single, double = numbers
    store(out, (0,), x + 2 * y)
    store(out, (1,), 1.0 - x)
    store(out, (2,), x * y / 3.0)
    store(out, (3,), sqrt(maximum(x, 0.0)))
    store(out, (4,), minimum(x, y))
    store(out, (5,), select(either(x < y, x > 0.5), -x, y))
    store(out, (6,), select(x < y, 0.0, 1))
    store(out, (7,), single * x + double * y)
    store(out, (8,), 4)


@njit
def _any_above(a, limit):
    return any_lane(load(a, (0,)) > limit)


@KINDS
def test_operators_agree_with_numpy(dtype):
    a, b = np.random.default_rng(1).normal(size=(2, 1, width(dtype))).astype(dtype)
    out = np.empty((9, width(dtype)), dtype)
    _everything(a, b, (np.float32(0.1), 0.1), out)
    x, y = a[0], b[0]
    expected = [
        x + 2 * y,
        1 - x,
        x * y / 3,
        np.sqrt(np.maximum(x, 0)),
        np.minimum(x, y),
        np.where((x < y) | (x > 0.5), -x, y),
        np.where(x < y, 0, 1),
        dtype(np.float32(0.1)) * x + dtype(0.1) * y,
        np.full_like(x, 4),
    ]
    np.testing.assert_array_equal(out, np.array(expected, dtype))


@KINDS
def test_any_lane_sees_every_lane(dtype):
    for lane in range(width(dtype)):
        a = np.zeros((1, width(dtype)), dtype)
        a[0, lane] = 1.0
        assert _any_above(a, 0.5)
    assert not _any_above(np.zeros((1, width(dtype)), dtype), 0.5)


@njit
def _places_up_to(numbers, row, limit, places):
    """List the lanes of a row of numbers that hold at most the limit."""
    found, count = bits(load(numbers, (row,)) <= limit), 0
    while found != 0:
        places[count] = lowest(found)
        found &= found - 1
        count += 1
    return count


@KINDS
def test_which_lanes_hold(dtype):
    numbers = np.random.default_rng(2).random((20, width(dtype))).astype(dtype)
    numbers[1, 3] = limit = dtype(0.5)
    places = np.empty(width(dtype), np.int64)
    for row in range(len(numbers)):
        count = _places_up_to(numbers, row, limit, places)
        np.testing.assert_array_equal(places[:count], np.flatnonzero(numbers[row] <= limit))


@njit
def _fuse(a, b, c, out):
    store(out, (0,), multiply_add(load(a, (0,)), load(b, (0,)), c))


@KINDS
def test_a_multiply_add_is_rounded_once(dtype):
    """(1 + e) (1 - e) - 1 is -e^2, of which rounding twice leaves nothing."""
    ones, small = np.ones((1, width(dtype)), dtype), np.finfo(dtype).eps
    out = np.empty_like(ones)
    _fuse(ones + small, ones - small, -1.0, out)
    np.testing.assert_array_equal(out, -(small**2))


MIXTURES = {
    "sum": lambda a, b: any_lane(load(a, (0,)) + load(b, (0,)) > 1.0),
    "choice": lambda a, b: any_lane(select(load(a, (0,)) > 0.0, load(b, (0,)), 0.0) > 1.0),
    "extreme": lambda a, b: any_lane(maximum(load(a, (0,)), load(b, (0,))) > 1.0),
    "either": lambda a, b: any_lane(either(load(a, (0,)) > 0.0, load(b, (0,)) > 0.0)),
    "copy": lambda a, b: store(a, (0,), load(b, (0,))),
}


@pytest.mark.parametrize("name", MIXTURES)
def test_single_and_double_do_not_mix(name):
    mixed, single, double = njit(MIXTURES[name]), np.ones((1, width(np.float32)), np.float32), np.ones((1, WIDTH))
    mixed(single, single)
    mixed(double, double)
    with pytest.raises(TypingError):
        mixed(single, double)


@pytest.mark.parametrize("array", [np.zeros((WIDTH, 2)).T, np.zeros((1, WIDTH), np.int64)])
def test_lanes_lie_in_rows_of_floats(array):
    with pytest.raises(TypingError, match="float32 or float64 in C order"):
        _any_above(array, 0.5)


FRAME = """
import hashlib
from hairpipe.graphs.experiments.bench.strands import one_block
from hairpipe.solve.implicit_stage import run_stage
arguments = one_block(6, "float64")
for _ in range(10):
    run_stage(*arguments)
print(hashlib.sha256(arguments[2].x.tobytes()).hexdigest(), sum(run_stage.stats.cache_hits.values()))
"""


def test_a_kernel_read_back_rounds_like_one_just_compiled(tmp_path):
    """Ten solves, a frame at 1/240 s, in two processes: what the compiler inlines must not show in a single bit."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_NUM_THREADS": "1"}
    runs = [
        subprocess.run([sys.executable, "-c", FRAME], env=environment, check=True, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    (compiled, hits), (read_back, hits_of_second) = (run.stdout.split() for run in runs)
    assert (hits, hits_of_second) == ("0", "1")
    assert compiled == read_back


@njit
def _project(parts, v, out):
    d, v = simd_vec4.load_short_four(parts, 1), simd_vec4.load_four(v, 2)
    result = simd_vec4.zeros() + simd_vec4.dot(d, v) * d - simd_vec4.item(d, 3) * v
    for place in range(3):
        out[place] = simd_vec4.item(result, place)


def test_it_multiplies_vectors_and_numbers():
    rng = np.random.default_rng(0)
    parts, v, out = np.int16([7, -32767, 32767, 4711, 16384]), rng.normal(size=6).astype(np.float32), np.empty(3)
    d, s = parts[1:4] / simd_vec4.WHOLE, parts[4] / simd_vec4.WHOLE
    _project(parts, v, out)
    np.testing.assert_allclose(out, d * (d @ v[2:5]) - s * v[2:5], rtol=1e-5)


@njit
def _spread(v, out):
    four = simd_vec4.load_four(v, 1)
    simd_vec4.store_four(out, 0, simd_vec4.dot_in_all(four, simd_vec4.load_four(v, 2)))
    simd_vec4.store_four(out, 5, simd_vec4.last_in_all(four))


def test_a_sum_and_the_last_number_are_in_all_four_and_are_written_where_they_belong():
    v, out = np.arange(1, 7, dtype=np.float32), np.full(10, -1.0, np.float32)
    _spread(v, out)
    assert out.tolist() == [*[2.0 * 3 + 3 * 4 + 4 * 5 + 5 * 6] * 4, -1.0, *[5.0] * 4, -1.0]


def test_it_loads_the_right_precision_only():
    with pytest.raises(TypingError, match="float32"):
        _project(np.zeros(5, np.int16), np.ones(6), np.empty(3))
    with pytest.raises(TypingError, match="int16"):
        _project(np.zeros(5, np.int32), np.ones(6, np.float32), np.empty(3))


@inlined
def twice(x):
    return 2 * x


@njit
def doubled(x):
    return twice(x) + twice(3)


def test_a_literal_is_compiled_as_any_number_of_its_type():
    assert doubled(4) == 14
    assert len(twice.signatures) == 1


def test_python_may_call_one():
    assert twice(1.5) == 3.0


def test_inlined_function_is_rebuilt_in_another_process():
    """Cached kernels refer to the functions in them."""
    states = pickle.loads(pickle.dumps(twice._reduce_states() | {"uuid": "another process", "py_func": None}))
    again = Inlined._rebuild(**states | {"py_func": twice.py_func})
    assert isinstance(again, Inlined) and again is not twice
    assert again.targetoptions == twice.targetoptions
