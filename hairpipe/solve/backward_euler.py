"""Backward Euler: one solve a step, and no history.

    M (v - v^n) = dt f(x^n + dt v),   linearised at x^n

With springs implicit along their direction only (`printed`) it is the fast mode: bounded at any step, accurate up to
about 1/120 s for long hair. Strands that the motion of their root strains are solved twice, see `Rule.guard`: a
prediction that moved them with their roots would avoid this, but would query body and hair at wrong positions. With
the tension of the present stretch it never diverges, but a swing loses most of its energy.
"""

from dataclasses import dataclass

import numpy as np

from hairpipe.solve.integrator import everywhere
from hairpipe.solve.lost import begin, hold_broken, recover, strain_of_loss
from hairpipe.solve.stage import Rule, Stage, State, Step
from hairpipe.solve.surroundings import Surroundings
from hairpipe.strands.interface import StrandModel


@dataclass(frozen=True, eq=False)
class BackwardEuler:
    """The fast mode: one solve a step."""

    rule: Rule

    def advance(self, model: StrandModel, state: State, step: Step, around: Surroundings) -> None:
        """Advance state by step, in place."""
        began = begin(model, state)
        before, v0, _ = began
        around.begin(state, step)
        state.v[:] = 0.0
        weights = everywhere(model, v0, step.dt)
        stage = Stage(before, v0, before, v0, step.ends(1.0), step.held, weights, step.time + step.dt, step.dt)
        kick = around.solve(state.x, state.v, state.T, stage, self.rule)
        np.divide(state.v - v0 - kick, step.dt, out=state.a)
        recover(self.rule, model, state, began, step, around, (kick,), strain_of_loss(model))
        state.fresh[:] = False
        around.end(state, before, step)
        hold_broken(model, state, began, step)
