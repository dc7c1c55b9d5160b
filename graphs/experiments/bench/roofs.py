"""Limits of the machine: multiply-adds in registers, and the bandwidth of memory."""

from collections.abc import Iterable
from typing import NamedTuple

import numba
import numpy as np
from numba import njit, prange
from numpy.typing import DTypeLike

from hairpipe.app.api.formatting import plural
from hairpipe.geometry.simd import load, multiply_add, store, width
from hairpipe.graphs.experiments.bench.repeat import Spread, repeat
from hairpipe.graphs.experiments.bench.report import Case

CHAINS = 8
"""Independent chains of multiply-adds: enough for two units of latency four."""
ROUNDS = 100_000
TRIAD = 1 << 24
"""Numbers in each of the three arrays of the triad: 128 MiB, more than any cache."""


class Roofs(NamedTuple):
    """Upper bounds on this machine.

    multiply_add  additions and multiplications per time on one core, by dtype [1/s]
    triad         bytes per time, by threads [1/s]
    """

    multiply_add: dict[str, Spread]
    triad: dict[int, Spread]

    @property
    def bandwidth(self) -> float:
        """Of memory, with most threads [GB/s]."""
        return 1e-9 * self.triad[max(self.triad)].median

    @property
    def cases(self) -> list[Case]:
        """The bounds as rows of a table."""
        rates = [(f"multiply-add, {dtype}, 1 thread", "GFLOP/s", rate) for dtype, rate in self.multiply_add.items()]
        rates += [(f"triad, {plural(threads, 'thread')}", "GB/s", rate) for threads, rate in self.triad.items()]
        return [{"limit": f"{name} [{unit}]", **rate.per(1e9).columns()} for name, unit, rate in rates]


def measure_roofs(dtypes: Iterable[str], threads: Iterable[int], count: int = TRIAD, seconds: float = 1.0) -> Roofs:
    """Measure both, the triad on arrays of so many numbers."""
    return Roofs(
        {dtype: measure_multiply_add(dtype, seconds) for dtype in dtypes},
        {thread_count: measure_triad(thread_count, count, seconds) for thread_count in threads},
    )


@njit(cache=True)
def _chain(start: np.ndarray, factor: float, shift: float, rounds: int) -> None:
    """Iterate y = factor y + shift in eight vectors, which never leave their registers, in place."""
    a, b, c, d = load(start, (0,)), load(start, (1,)), load(start, (2,)), load(start, (3,))
    e, f, g, h = load(start, (4,)), load(start, (5,)), load(start, (6,)), load(start, (7,))
    m, s = 0.0 * a + factor, 0.0 * a + shift
    for _ in range(rounds):
        a, b, c, d = multiply_add(a, m, s), multiply_add(b, m, s), multiply_add(c, m, s), multiply_add(d, m, s)
        e, f, g, h = multiply_add(e, m, s), multiply_add(f, m, s), multiply_add(g, m, s), multiply_add(h, m, s)
    store(start, (0,), a + b + c + d)
    store(start, (1,), e + f + g + h)


def measure_multiply_add(dtype: DTypeLike, seconds: float) -> Spread:
    """Measure multiplications and additions per time on one core [1/s], fused where the processor can."""
    start = np.zeros((CHAINS, width(dtype)), dtype)
    operations = 2 * CHAINS * width(dtype) * ROUNDS
    return repeat(lambda: _chain(start, 0.5, 1.0, ROUNDS), seconds).rate(operations)


@njit(cache=True, parallel=True)
def _triad(a: np.ndarray, b: np.ndarray, c: np.ndarray, factor: float) -> None:
    for i in prange(len(a)):
        a[i] = b[i] + factor * c[i]


def measure_triad(threads: int, count: int, seconds: float) -> Spread:
    """Measure bytes per time of a = b + s c [1/s]: two reads and a write a number, as STREAM counts them."""
    a = np.zeros(count)
    b = np.ones(count)
    c = np.ones(count)
    with_threads = numba.get_num_threads()
    numba.set_num_threads(threads)
    try:
        return repeat(lambda: _triad(a, b, c, 3.0), seconds).rate(3 * a.nbytes)
    finally:
        numba.set_num_threads(with_threads)
