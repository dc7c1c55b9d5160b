"""TR-BDF2, linearly implicit: the trapezoidal rule to t + g dt, then second-order backward differences to t + dt.

With g = 2 - sqrt 2 both stages have the same weight h = g dt / 2 and the scheme is L-stable and of second order:

    1   xh = x + h v,        vh = v + h a,         guess v
    2   xh = w1 x1 - w0 x,   vh = w1 v1 - w0 v,    guess v1

with w1 = 1 / (g (2 - g)), w0 = (1 - g)^2 w1 and a = (v - vh) / h of the last stage, so that forces are not evaluated
again. Each stage is one solve, linearised at the prediction. Strands that a step loses repeat it, see `lost.py`.

Forces between strands change velocities within a stage as in backward Euler: they are removed from v - vh and from v1
- v, so that no stage reverses the impacts of the previous one. Strands whose forces have jumped restart: their first
stage is one of backward Euler, see `integrator.py`.

We differ from the paper, whose half step and trapezoid (Sec. 4) gain or lose energy at steps at which this scheme is
accurate.
Source: Bank et al., Transient Simulation of Silicon Devices and Circuits, 1985; Hosea and Shampine, 1996.
"""

from dataclasses import dataclass

import numpy as np

from hairpipe.geometry.simd import combine_all, copied
from hairpipe.solve.integrator import (
    ContactChange,
    add_change,
    everywhere,
    restart_fresh,
    sum_changes,
)
from hairpipe.solve.lost import begin, hold_broken, recover
from hairpipe.solve.stage import Rule, Stage, State, Step
from hairpipe.solve.surroundings import Surroundings
from hairpipe.strands.interface import StrandModel

G = 2.0 - np.sqrt(2.0)
_W1 = 1.0 / (G * (2.0 - G))
_W0 = (1.0 - G) ** 2 * _W1


@dataclass(frozen=True, eq=False)
class TrBdf2:
    """The default integrator: two solves a step."""

    rule: Rule

    def advance(self, model: StrandModel, state: State, step: Step, around: Surroundings) -> None:
        """Advance state by step, in place."""
        self.take_step(model, state, step, around)

    def take_step(self, model: StrandModel, state: State, step: Step, around: Surroundings) -> ContactChange:
        """Advance state by step, in place; return what contact changed."""
        x, v, T, dt = state.x, state.v, state.T, step.dt
        began = begin(model, state)
        h = G * dt / 2
        x0, v0 = began.x, began.v
        around.begin(state, step)
        xh, vh = np.empty_like(x), np.empty_like(x)
        combine_all(xh, 1.0, x0, h, v0)
        combine_all(vh, 1.0, v0, h, state.a)
        weights = restart_fresh(model, state, xh, vh, everywhere(model, x, h), G * dt)
        stage = Stage(xh, vh, x0, v, step.ends(G), step.held, weights, step.time + G * dt, G * dt)
        first = around.solve(x, v, T, stage, self.rule)
        x1 = copied(x)
        combine_all(xh, _W1, x1, -_W0, x0)
        combine_all(vh, _W1, v, -_W0, v0)
        add_change(vh, -_W0, first)
        weights = everywhere(model, x, h)
        stage = Stage(xh, vh, x1, v, step.ends(1.0), step.held, weights, step.time + dt, (1.0 - G) * dt)
        second = around.solve(x, v, T, stage, self.rule)
        combine_all(state.a, 1 / h, v, -1 / h, vh)
        add_change(state.a, -1 / h, second)
        recover(self.rule, model, state, began, step, around, (first, second))
        changed = around.end(state, x0, step)
        hold_broken(model, state, began, step)
        state.fresh[:] = around.discontinuous(x) != 0.0
        return sum_changes(sum_changes(first, second), changed)
