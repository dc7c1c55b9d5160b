"""The hardest motion of roots in a shot, which a promise holds for."""

from dataclasses import dataclass

import numpy as np

from hairpipe.tune.sampling import window_length

SLACK = 1.02
"""Ratio up to which two motions are as hard: figures are printed with three digits."""


@dataclass(frozen=True)
class RootMotion:
    """The hardest motion of roots, root mean square over the strands.

    speed         largest of a frame [m/s]
    acceleration  largest root mean square over half a second [m/s^2]
    """

    speed: float
    acceleration: float

    def includes(self, other: "RootMotion") -> bool:
        """Whether another motion is no harder."""
        return other.speed <= SLACK * self.speed and other.acceleration <= SLACK * self.acceleration

    def __str__(self) -> str:
        return f"{self.speed:.3g} m/s and {self.acceleration:.3g} m/s^2"


STILL = RootMotion(0.0, 0.0)
"""That of roots that do not move."""


def hardest(speeds: np.ndarray, accelerations: np.ndarray, fps: float) -> RootMotion:
    """Return the hardest motion, from the root mean squares over the strands of all frames of a shot.

    speeds         of every frame [m/s], (frames,)
    accelerations  of every frame [m/s^2], (frames,)
    """
    length = window_length(len(accelerations), fps)
    squares = np.convolve(accelerations**2, np.full(length, 1.0 / length), "valid")
    return RootMotion(float(speeds.max()), float(np.sqrt(squares.max())))
