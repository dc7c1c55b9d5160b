"""What a kernel does, counted."""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.geometry import simd
from hairpipe.geometry.simd import load, maximum, select, sqrt, store
from hairpipe.graphs.experiments.bench.arithmetic.counting import Work, count_work
from hairpipe.graphs.experiments.bench.strands import hang, one_block
from hairpipe.solve.implicit_stage import run_stage


@njit
def _halved(x):
    return 0.5 * x


@njit
def _kernel(a, out, steps):
    made = np.zeros_like(a)
    for i in range(steps):
        x = load(a, (i,))
        store(made, (i,), x + 1.0)
        y = select(x > 2.0, _halved(load(made, (i,))), maximum(x, 0.0))
        store(out, (i,), sqrt(y) / 3.0 - x)
        store(out, (i,), load(out, (i,)) * (2.0 * 4.0))


def test_operations_and_bytes_are_those_of_the_source():
    """Six operations a row: + * sqrt / - *; a is read, out written; what is made inside or read back does not count."""
    a, out, compiled = np.random.default_rng(1).uniform(0, 4, (3, 3, 8))
    assert count_work(_kernel, a, out, 2) == Work(2 * 6, 2 * 2 * 8)
    compiled[2] = out[2]
    _kernel(a, compiled, 2)
    np.testing.assert_array_equal(out, compiled)
    assert Work(12, 32).per(2) == Work(6, 16)


class _Pair(NamedTuple):
    a: np.ndarray
    out: np.ndarray


@njit
def _first_of(pair, i):
    simd.store(pair.out, (i,), load(pair.a, (i,)) * 2.0)


def test_arrays_of_a_tuple_count_too():
    pair = _Pair(np.ones((2, 16), np.float32), np.ones((2, 16), np.float32))
    assert count_work(_first_of, pair, 1) == Work(1, 8)


def test_a_solve_in_python_gives_the_same_numbers():
    """What is counted is the kernel itself; and its machine code rounds nothing otherwise than numpy does."""
    counted, compiled = (one_block(12, "float64") for _ in range(2))
    work = count_work(run_stage, *counted)
    run_stage(*compiled)
    for mine, theirs in zip(counted[2], compiled[2], strict=True):
        np.testing.assert_array_equal(mine, theirs)
    particles = hang(8, 12, "float64").particles / 8
    assert 500 < work.operations / particles < 3000
    assert 100 < work.bytes / particles < 500
