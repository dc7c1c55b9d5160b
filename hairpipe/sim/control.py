"""How the time between two frames is cut into steps."""

from math import ceil

import numpy as np
from numba import njit

from hairpipe.sim.roots import Clamps, between
from hairpipe.sim.scene import StepControl


def next_step(
    limits: StepControl, velocities: np.ndarray, start: Clamps, end: Clamps, frame: float, time: float
) -> float:
    """Choose the step from a time since the last frame: an equal share of what is left of the frame [s].

    velocities  of all particles [m/s], (rows, 3, WIDTH)
    start, end  clamped particles at both frames; frame  time between them [s]
    """
    left = frame - time
    count = max(ceil(left / limits.longest - 1e-6), ceil(left * _largest(velocities) / limits.travel), 1)
    here = between(start, end, frame, time)
    while _largest((between(start, end, frame, time + left / count) - here).reshape(-1, *here.shape[2:])) > limits.root:
        count += 1
    return left / count


@njit(cache=True)
def _largest(vectors: np.ndarray) -> float:
    """Length of the longest finite vector of (n, 3, WIDTH)."""
    longest = 0.0
    for n in range(vectors.shape[0]):
        for lane in range(vectors.shape[2]):
            size = vectors[n, 0, lane] ** 2 + vectors[n, 1, lane] ** 2 + vectors[n, 2, lane] ** 2
            if longest < size < np.inf:
                longest = size
    return np.sqrt(longest)
