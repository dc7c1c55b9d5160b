"""Impulse of a force in a frame, summed as the integrators sum it: what the force adds to the momentum of hair.

A stage x = xh + h v, v = vh + h f / m over a span s adds, to round-off,

    (s - h) f_ + h f

where f is the force at its end and f_ what the scheme takes for it before: the force at the start of the step in the
trapezoidal rule, h = s / 2; otherwise the mean force since the start of the step, or over the last step where the stage
begins with the step (BDF2). Backward Euler, h = s, has no such part. We neglect that corrections after the solves move
hair between steps.

Settings of the shape goal, in physical units.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from hairpipe.groom.painting import Varied
from hairpipe.units import Hertz, Interval

_EQUAL = 1e-6
"""Relative difference of times that rounding may make."""


class Impulse:
    """The impulse on every one of k points.

    last_solve_only  whether the last solve of a step makes all of its velocity: the nine steps
    """

    def __init__(self, count: int) -> None:
        """Begin a frame without impulse."""
        self.last_solve_only = False
        self._frame, self._step = np.zeros((2, count, 3))
        self._force = self._mean = self._step
        self._time = self._dt = 0.0

    @property
    def total(self) -> np.ndarray:
        """The impulse since the frame began [N s], (k, 3)."""
        return self._frame + self._step

    def begin(self, force: np.ndarray, time: float, dt: float) -> None:
        """Begin a step of dt [s] at a time since the frame [s], where the force [N] is (k, 3)."""
        self._frame = self.total
        self._mean = self._step / self._dt if self._dt else force
        self._step = np.zeros_like(force)
        self._force, self._time, self._dt = force, time, dt
        self._stage, self._began = np.nan, self._step

    def add(self, force: np.ndarray, weights: np.ndarray, active: np.ndarray, time: float, span: float) -> None:
        """Add a stage that ends at a time with a force [N], (k, 3).

        weights, active  weight of the end [s], and whether its strand was solved now, (k,): otherwise nothing changes
        span             duration of the stage [s]
        """
        if self.last_solve_only:
            self._step = np.where(active[:, None], self._dt * force, self._step)
            return
        if time != self._stage:
            self._stage, self._began = time, self._step.copy()
        before = time - span - self._time
        trapezoid = (np.abs(2.0 * weights - span) < _EQUAL * span)[:, None]
        if before < _EQUAL * self._dt:
            began = np.zeros_like(force)
            earlier = np.where(trapezoid, self._force, self._mean)
        else:
            began = self._began
            earlier = began / before
        end = weights[:, None]
        self._step = np.where(active[:, None], began + (span - end) * earlier + end * force, self._step)


FREQUENCIES = Interval(ge=0.0, le=1e4)


@dataclass(frozen=True)
class Frequency(Varied):
    __doc__ = Varied.__doc__
    value: Annotated[Hertz, FREQUENCIES]
    low: Annotated[Hertz, FREQUENCIES] = 0.0


@dataclass(frozen=True)
class Goal:
    """Pull of every point of hair to its place in the groom, which the skin carries rigidly.

    frequency  natural frequency of a free point about its place; 0 where there is no pull
    damping    ratio of damping to critical damping, for motion relative to that place
    """

    frequency: Frequency = Frequency(4.0)
    damping: Annotated[float, Interval(ge=0.0, le=100.0)] = 1.0
