"""How the time between two frames is cut into steps."""

from dataclasses import dataclass
from math import ceil
from typing import Annotated

import numpy as np

from hairpipe.sim.roots import Clamps, between
from hairpipe.units import Interval, Metres, Seconds


@dataclass(frozen=True)
class StepControl:
    """Steps as long as they may be, and no longer.

    longest  step
    root     a root moves at most this far in a step: 1 cm in the authors' code (physics.md 1.7)
    travel   a particle moves at most this far in a step, so that it cannot leap over the band of the level set
    """

    longest: Annotated[Seconds, Interval(gt=1e-6, le=1.0)] = 1 / 240
    root: Annotated[Metres, Interval(gt=1e-5, le=1.0)] = 0.01
    travel: Annotated[Metres, Interval(gt=1e-5, le=1.0)] = 0.02

    def next_step(self, velocities: np.ndarray, start: Clamps, end: Clamps, frame: float, time: float) -> float:
        """Choose the step from a time since the last frame, an equal share of what is left of the frame [s].

        velocities  of all particles [m/s], (rows, 3, WIDTH)
        start, end  clamped particles at both frames; frame  time between them [s]
        """
        left = frame - time
        count = ceil(left / self.longest - 1e-6)
        speed = _largest(velocities)
        if speed > 0.0:
            count = max(count, ceil(left * speed / self.travel))
        here = between(start, end, frame, time)
        while _largest(between(start, end, frame, time + left / count) - here) > self.root:
            count += 1
        return left / count


def _largest(vectors: np.ndarray) -> float:
    """Length of the longest vector of (..., 3, WIDTH)."""
    return float(np.sqrt(np.max(np.sum(vectors**2, axis=-2))))
