"""The cost of a parallel call: a loop over few numbers, called again and again.

With some versions of TBB a call costs more than the one before, so early and late calls are measured apart.
"""

import time

import numpy as np
from numba import njit, prange

SIZE = 2000


@njit(parallel=True)
def add_one(x: np.ndarray) -> None:
    """Add 1 to every number, (n,) float64, in place."""
    for i in prange(len(x)):
        x[i] += 1.0


def measure_calls(early: int, late: int) -> tuple[float, float]:
    """Measure the median cost of the first calls and of as many after so many others [us]."""
    x = np.zeros(SIZE)
    add_one(x)
    medians = []
    for waiting in (0, late):
        for _ in range(waiting):
            add_one(x)
        spent = []
        for _ in range(early):
            begun = time.perf_counter()
            add_one(x)
            spent.append(time.perf_counter() - begun)
        medians.append(1e6 * float(np.median(spent)))
    return medians[0], medians[1]
