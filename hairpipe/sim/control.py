"""How the time between two frames is cut into steps."""

from math import ceil

import numpy as np

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
    while _largest(between(start, end, frame, time + left / count) - here) > limits.root:
        count += 1
    return left / count


def _largest(vectors: np.ndarray) -> float:
    """Length of the longest finite vector of (..., 3, WIDTH)."""
    squares = np.sum(vectors**2, axis=-2)
    return float(np.sqrt(np.max(squares, initial=0.0, where=np.isfinite(squares))))
