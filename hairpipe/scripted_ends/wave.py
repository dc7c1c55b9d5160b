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
    """Periodic motion from rest at time zero, in addition to keys.

    form       form of the velocity: sine, or square of constant speed and alternating sign
    frequency  frequency of the oscillation
    speed      maximum speed of the end
    along      direction of the first half period
    turning    maximum angular speed about the axis
    axis       axis of the rotations
    pivot      vector from the end to a point of the axis
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
    velocity = wave.speed * unit(wave.along, "along")
    turning = np.radians(wave.turning)
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
