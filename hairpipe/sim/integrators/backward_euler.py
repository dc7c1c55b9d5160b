"""Backward Euler: one solve a step, and no history.

    M (v - v^n) = dt f(x^n + dt v),   linearised at x^n

With springs implicit along their direction only (`printed`) it is the fast mode: bounded at any step, good to
about 1/120 s for long hair. Strands whose root moves so far that this strains them solve twice, see `Rule.guard`: gone
along with their roots they would not, but then body and hair are looked at where they do not come. With the tension of
the present stretch nothing makes it diverge, and a swing loses most of its energy.
"""

from dataclasses import dataclass

import numpy as np

from hairpipe.sim.integrators.interface import everywhere
from hairpipe.sim.solve.stage import Rule, Stage
from hairpipe.sim.state import Motion, Step
from hairpipe.sim.strands.interface import StrandModel
from hairpipe.sim.surroundings import Surroundings


@dataclass(frozen=True, eq=False)
class BackwardEuler:
    """The fast mode: one solve a step."""

    rule: Rule

    def advance(self, model: StrandModel, motion: Motion, step: Step, around: Surroundings) -> None:
        """Advance motion by step, in place."""
        before, v0 = motion.x.copy(), motion.v.copy()
        around.begin(motion, step)
        motion.v[:] = 0.0
        weights = everywhere(model, v0, step.dt)
        stage = Stage(before, v0, before, v0, step.ends(1.0), step.held, weights, step.time + step.dt, step.dt)
        kick = around.solve(motion.x, motion.v, motion.T, stage, self.rule)
        np.divide(motion.v - v0 - kick, step.dt, out=motion.a)
        around.end(motion, before, step)
