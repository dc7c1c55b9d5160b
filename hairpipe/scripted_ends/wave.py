"""Motion to and fro."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from hairpipe.scripted_ends.rigid_paths import Course, Vector, unit
from hairpipe.units import DegreesPerSecond, Gt, Metres, MetresPerSecond, PerSecond

Shift = tuple[Metres, Metres, Metres]
CLOSE = 1e-9  # in half waves: closer to where a square wave turns round it stands


@dataclass(frozen=True)
class Wave:
    """Motion to and fro, from rest at time zero, in the frame of the keys where there are any.

    form       sine is a speed that comes and goes; square is constant speed that turns round at once, where it is 0
    frequency  of going to and fro
    speed      the fastest that the end is moved
    along      direction in which it goes first
    turning    the fastest that it is turned about the axis
    axis       of the turns
    pivot      from the end to a point of that axis
    """

    form: Literal["sine", "square"] = "sine"
    frequency: Annotated[PerSecond, Gt(0.0)] = 2.0
    speed: MetresPerSecond = 0.0
    along: Vector = (1.0, 0.0, 0.0)
    turning: DegreesPerSecond = 0.0
    axis: Vector = (0.0, 1.0, 0.0)
    pivot: Shift = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Raise BadInput where a direction has no length."""
        unit(self.along, "along")
        unit(self.axis, "axis")


def course_of_wave(wave: Wave, time: float) -> Course:
    """Find how far an end is moved and turned at a time [s]."""
    seconds, share = gone(wave, max(time, 0.0))
    velocity, turning = wave.speed * unit(wave.along, "along"), np.radians(wave.turning)
    return Course(seconds * velocity, share * velocity, seconds * turning, share * turning)


def gone(wave: Wave, time: float) -> tuple[float, float]:
    """Return the way gone over the fastest speed [s], and the present speed over the fastest."""
    phase = wave.frequency * time
    if wave.form == "sine":
        angle = 2.0 * np.pi * phase
        return (1.0 - np.cos(angle)) / (2.0 * np.pi * wave.frequency), np.sin(angle)
    within = phase % 1.0
    turns = abs(2.0 * phase - round(2.0 * phase)) < CLOSE
    return min(within, 1.0 - within) / wave.frequency, 0.0 if turns else 1.0 if within < 0.5 else -1.0
