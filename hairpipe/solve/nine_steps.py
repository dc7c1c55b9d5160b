"""The nine steps of Sec. 4 of Selle, Lentine, Fedkiw 2008, after Sifakis et al. 2007.

    1  v* = v^n + dt/2 a(x^n, v*)                       4  x^n+1 = x^n + dt v*
    2  strain limiting changes v*                       5  body collisions change x^n+1 and v^n
    3  repulsions between hairs change v*               6  collisions between hairs change x^n+1 and v^n
    7  vh = v^n + dt/2 a(x^n+1/2, vh),  x^n+1/2 = (x^n + x^n+1) / 2
    8  v^n+1 = 2 vh - v^n                               9  repulsions between hairs change v^n+1

v* moves the hair and is discarded. Solves are implicit according to the spring form, linearised at the known
positions. The authors' archived code has full backward Euler at x^n+1 for 7 and 8, the other choice here.

Steps 3, 5, 6 and 9 are those of `sim/contact/`; points that touched the body in 5 have their normal component held in
7. So resting hair has no velocity into the body before 5, and friction there, in proportion to the velocity removed,
reduces the displacement of hair in a step but not its velocity. Wind and stiction are forces of 1 and 7.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from hairpipe.solve.integrator import everywhere
from hairpipe.solve.stage import Rule, Stage, State, Step
from hairpipe.solve.surroundings import Surroundings
from hairpipe.strands.interface import StrandModel


@dataclass(frozen=True, eq=False)
class NineSteps(ABC):
    """Two solves a step: one for the positions, one for the velocities."""

    rule: Rule

    def advance(self, model: StrandModel, state: State, step: Step, around: Surroundings) -> None:
        """Advance state by step, in place."""
        x = state.x.copy()
        v = state.v
        before = state.v.copy()
        dt = step.dt
        around.begin(state, step)
        around.leave_to_corrections()  # bodies hold only what step 5 has moved
        v_star = self.solve(state, step, around, x, dt / 2, 0.5, step.time)  # 1
        around.limit_velocity(x, v_star, step)  # 2
        around.repel(x, v_star, step, elastic=True)  # 3
        state.x[:] = x + dt * v_star  # 4
        around.correct(state.x, v, x, step)  # 5, 6
        state.v[:] = self.velocity(state, step, around, x)  # 7, 8
        around.repel(state.x, state.v, step, elastic=False)  # 9
        np.divide(state.v - before, dt, out=state.a)
        state.fresh[:] = False

    @abstractmethod
    def velocity(self, state: State, step: Step, around: Surroundings, before: np.ndarray) -> np.ndarray:
        """Find v^n+1 [m/s], (rows, 3, W), of a state with x^n+1 and v^n; before is x^n [m], same shape."""

    def solve(
        self, state: State, step: Step, around: Surroundings, x: np.ndarray, h: float, part: float, time: float
    ) -> np.ndarray:
        """Solve v = v^n + h a(x + h v, v) linearised at x [m], (rows, 3, W).

        part  share of the step after which held particles are at x + h v, at their mean velocity
        time  time of bodies and wind [s]
        """
        moved = x.copy()
        v = np.zeros_like(x)
        start = step.ends(0.0)
        ends = start + part * (step.ends(1.0) - start)
        weights = everywhere(around.model, x, h)
        stage = Stage(x, state.v, x, state.v, ends, step.held, weights, time, h)
        around.solve(moved, v, state.T, stage, self.rule)
        return v


@dataclass(frozen=True, eq=False)
class Trapezoid(NineSteps):
    """Steps 7 and 8 as printed."""

    def velocity(self, state: State, step: Step, around: Surroundings, before: np.ndarray) -> np.ndarray:
        """v^n+1 = 2 vh - v^n with vh = v^n + dt/2 a(x^n+1/2, vh)."""
        middle = step.time + step.dt / 2
        half = self.solve(state, step, around, (before + state.x) / 2, step.dt / 2, 1.0, middle)
        return 2 * half - state.v


@dataclass(frozen=True, eq=False)
class FullStep(NineSteps):
    """Steps 7 and 8 as the authors' code has them."""

    def velocity(self, state: State, step: Step, around: Surroundings, before: np.ndarray) -> np.ndarray:
        """v^n+1 = v^n + dt a(x^n+1 + dt v^n+1, v^n+1): the stiffness reaches a step ahead, which damps."""
        return self.solve(state, step, around, state.x, step.dt, 2.0, step.time + step.dt)
