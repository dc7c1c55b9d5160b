"""Machine code, read."""

import numpy as np
import pytest
from numba import njit

from hairpipe.geometry.simd import load, store
from hairpipe.graphs.experiments.bench.arithmetic.assembly import Arithmetic, assembly_of, count_arithmetic
from hairpipe.graphs.experiments.bench.strands import machine_code

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


@njit
def _lanes(a):
    for i in range(len(a)):
        x = load(a, (i,))
        store(a, (i,), x * x + 3.0)


@njit
def _numbers(a):
    x = a[0, 0]
    for i in range(a.shape[0]):
        x = x * x + a[i, 0]
    return x


def test_vectors_and_numbers_are_distinguished():
    code = {
        kernel: count_arithmetic(assembly_of(kernel, np.ones((4, 8))).splitlines()) for kernel in (_lanes, _numbers)
    }
    assert code[_lanes].packed == 1.0 and code[_lanes].scalar == 0
    assert code[_numbers].packed < 0.5


def test_a_solve_computes_in_vectors():
    """Two thousand instructions of arithmetic; scalar are the few numbers that all strands share."""
    code = count_arithmetic(machine_code("float64").splitlines())
    assert sum(code) > 1000
    assert code.packed > 0.98
