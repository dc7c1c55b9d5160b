"""Goals as an interaction: a damped spring from a point of hair to a place that a body carries.

The force on a point of mass m at x with velocity v, whose goal is g(t), is

    f = m w^2 (g - x) + 2 z m w (g' - v),   w = 2 pi frequency,   z the ratio of damping,

the negative gradient of m w^2 |x - g|^2 / 2 and a damper. It is linear in x and v: in the solve it is fully implicit,
on the diagonal of the banded system, and stable for any step. A goal moves on the cubic through the places and
velocities of two frames, as the clamps at the roots do (`sim/boundary.py`).
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.data.hair import HairState
from hairpipe.kernels.compile import inlined
from hairpipe.sim.goal.impulse import Impulse
from hairpipe.sim.interactions import Interaction, Prediction, Start


class Springs(NamedTuple):
    """Springs of some points: their indices, (k,) int64, stiffness [N/m] and damping [kg/s], (k,)."""

    points: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray


class Path(NamedTuple):
    """Places of goals between two frames: motions of rest points.

    owners              motion of every goal, (k,) int64
    rest                its point at rest [m], (k, 3)
    start, start_rate   motions x -> R x + t at the first frame, and their rates, (n, 3, 4)
    end, end_rate       the same at the second
    frame_dt            time between the frames [s]
    """

    owners: np.ndarray
    rest: np.ndarray
    start: np.ndarray
    start_rate: np.ndarray
    end: np.ndarray
    end_rate: np.ndarray
    frame_dt: float

    def motions(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return all motions at a time since the first frame [s] and their rates, on the cubic, (n, 3, 4)."""
        dt = self.frame_dt
        s = time / dt

        def blend(a: float, b: float, c: float, d: float) -> np.ndarray:
            return a * self.start + b * dt * self.start_rate + c * self.end + d * dt * self.end_rate

        place = blend((1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2, s**2 * (3 - 2 * s), s**2 * (s - 1))
        slope = blend(6 * s * (s - 1), (1 - s) * (1 - 3 * s), 6 * s * (1 - s), s * (3 * s - 2))
        return place, slope / dt


@dataclass(eq=False)
class GoalPull(Interaction):
    """Goals of some points of hair in a frame.

    springs  springs to the goals
    path     places of the goals
    strands  strand of every point of hair, (P,)
    """

    springs: Springs
    path: Path
    strands: np.ndarray

    def __post_init__(self) -> None:
        self._impulse = Impulse(len(self.springs.points))

    def begin(self, start: Start) -> None:
        """Begin to sum the impulse of a step."""
        force = self.force(start.points, start.velocities, start.time)
        self._impulse.begin(force, start.time, start.dt)

    def leave_to_corrections(self) -> None:
        """Sum the impulse as the nine steps do, whose last solve alone makes velocities."""
        self._impulse.last_solve_only = True

    def linearise(self, at: Prediction, push: np.ndarray, damping: np.ndarray) -> None:
        """Add the forces of the goals at the end of a stage, in place."""
        _add_pull(at, self.springs, self.path.owners, self.path.rest, *self.path.motions(at.time), push, damping)

    def judge(self, at: Prediction, again: np.ndarray) -> None:
        """Note the force at the end of a stage that has been solved."""
        points = self.springs.points
        force = self.force(at.points, at.velocities, at.time)
        free = at.active[points] & np.isfinite(at.masses[points])  # Held points are moved by their clamps.
        self._impulse.add(force, at.weights[points], free, at.time, at.span)

    def force(self, points: np.ndarray, velocities: np.ndarray, time: float) -> np.ndarray:
        """Return the forces of the goals [N], (k, 3), on hair at points [m] with velocities [m/s], (P, 3)."""
        force = np.empty((len(self.springs.points), 3))
        place, rate = self.path.motions(time)
        _find_force(points, velocities, self.springs, self.path.owners, self.path.rest, place, rate, force)
        return force

    def remember(self, state: HairState) -> HairState:
        """Return the state with the impulses of these goals in this frame, added to those of others; pure."""
        strands = self.strands[self.springs.points]
        count = self.strands[-1] + 1
        total = self._impulse.total
        own = np.stack([np.bincount(strands, total[:, c], count) for c in range(3)], axis=1)
        return replace(state, impulses=own if state.impulses is None else state.impulses + own)


@inlined
def _moved(motion, rest, i, c):
    """Return component c of rest point i under a motion (3, 4)."""
    return motion[c, 0] * rest[i, 0] + motion[c, 1] * rest[i, 1] + motion[c, 2] * rest[i, 2] + motion[c, 3]


@njit(cache=True, parallel=True)
def _add_pull(at, springs, owners, rest, place, rate, push, damping):
    """Add push - damping v of the goals on active points, in place; the points are distinct."""
    for i in prange(len(springs.points)):
        k = springs.points[i]
        if at.active[k]:
            h, stiffness, d = at.weights[k], springs.stiffness[i], springs.damping[i]
            for c in range(3):
                away = _moved(place[owners[i]], rest, i, c) - at.points[k, c]
                push[k, c] += stiffness * (away + h * at.velocities[k, c]) + d * _moved(rate[owners[i]], rest, i, c)
            for diagonal in (0, 3, 5):
                damping[k, diagonal] += h * stiffness + d


@njit(cache=True, parallel=True)
def _find_force(points, velocities, springs, owners, rest, place, rate, force):
    """Set the forces of the goals, (k, 3), in place."""
    for i in prange(len(springs.points)):
        k = springs.points[i]
        for c in range(3):
            away = _moved(place[owners[i]], rest, i, c) - points[k, c]
            slip = _moved(rate[owners[i]], rest, i, c) - velocities[k, c]
            force[i, c] = springs.stiffness[i] * away + springs.damping[i] * slip
