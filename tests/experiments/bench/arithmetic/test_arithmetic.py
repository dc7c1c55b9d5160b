"""Machine code is read, and what kernels do is counted."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.simd import load, maximum, select, sqrt, store
from hairpipe.graphs.experiments.bench.arithmetic.assembly import Arithmetic, count_arithmetic
from hairpipe.graphs.experiments.bench.arithmetic.counting import Work, count_work
from hairpipe.graphs.experiments.bench.strands import hang, machine_code, one_block
from hairpipe.solve.implicit_stage import run_stage

CODE = """
    vaddpd  %zmm1, %zmm2, %zmm3
    vmulps  64(%rsp), %ymm2, %ymm3
    vfmadd231pd (%rax){1to8}, %zmm17, %zmm3
    vdivpd  %xmm1, %xmm2, %xmm3
    vaddsd  %xmm1, %xmm2, %xmm3
    sqrtss  %xmm1, %xmm2
    vmovupd %zmm1, (%rax)
    addq    $8, %rax
"""


def test_arithmetic_is_distinguished_from_other_instructions():
    assert count_arithmetic(CODE.splitlines()) == Arithmetic(zmm=2, ymm=1, xmm=1, scalar=2)
    assert count_arithmetic(CODE.splitlines()).packed == pytest.approx(4 / 6)


def test_a_solve_computes_in_vectors():
    """Two thousand instructions of arithmetic; scalar are the few numbers that all strands share."""
    code = count_arithmetic(machine_code("float64").splitlines())
    assert sum(code) > 1000
    assert code.packed > 0.98


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
