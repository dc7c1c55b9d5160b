"""BDF2, linearly implicit: second-order backward differences with one solve a step.

    xh = w1 x^n - w0 x^n-1,  vh = w1 v^n - w0 v^n-1,  h = (1 + r) / (1 + 2 r) dt,  guess v^n

with r = dt / dt_before, w1 = (1 + r)^2 / (1 + 2 r), w0 = r^2 / (1 + 2 r). It uses the previous step, which is not
stored at frames: the first step of a frame is one of TR-BDF2, so that a frame needs no more state than that scheme,
and with one step per frame the two are equal. Forces between strands are not part of the differences; a strand whose
forces jumped takes its next step by backward Euler, in one system with the others, as in TR-BDF2.
"""

from dataclasses import dataclass, field

import numpy as np

from hairpipe.solve.integrator import everywhere, restart_fresh, rows_of
from hairpipe.solve.lost import begin, hold_broken, recover, strain_of_loss
from hairpipe.solve.stage import Rule, Stage, State, Step
from hairpipe.solve.surroundings import Surroundings
from hairpipe.solve.tr_bdf2 import TrBdf2
from hairpipe.strands.interface import StrandModel


@dataclass(eq=False)
class Bdf2:
    """One solve a step after the first of a frame."""

    rule: Rule
    _before: tuple[np.ndarray, np.ndarray, float] | None = field(default=None, init=False)

    def advance(self, model: StrandModel, state: State, step: Step, around: Surroundings) -> None:
        """Advance state by step, in place."""
        began = begin(model, state)
        x0, v0, _ = began
        if step.time == 0.0 or self._before is None:
            kick = TrBdf2(self.rule).take_step(model, state, step, around)
        else:
            x1, v1, dt = self._before
            r = step.dt / dt
            w1 = (1 + r) ** 2 / (1 + 2 * r)
            w0 = r**2 / (1 + 2 * r)
            h = (1 + r) / (1 + 2 * r) * step.dt
            xh, vh = w1 * x0 - w0 * x1, w1 * v0 - w0 * v1
            around.begin(state, step)
            weights = restart_fresh(model, state, xh, vh, everywhere(model, x0, h), step.dt)
            stage = Stage(xh, vh, x0, state.v, step.ends(1.0), step.held, weights, step.time + step.dt, step.dt)
            kick = around.solve(state.x, state.v, state.T, stage, self.rule)
            np.divide(state.v - vh - kick, rows_of(model, weights), out=state.a)
            recover(self.rule, model, state, began, step, around, (kick,), strain_of_loss(model))
            kick = kick + around.end(state, x0, step)
            hold_broken(model, state, began, step)
        state.fresh[:] = around.discontinuous(state.x) != 0.0
        self._before = x0, v0 + kick, step.dt
