"""Backward Euler: one solve a step, and no history.

    M (v - v^n) = dt f(x^n + dt v),   linearised at x^n, gone along with the root

With springs implicit along their direction only (`printed`) it is the fast mode: bounded at any step, good to
about 1/120 s for long hair. With the tension of the present stretch nothing makes it diverge, and a swing loses most of
its energy.
"""

from dataclasses import dataclass

import numpy as np

from hairpipe.sim.integrators.interface import along_with_roots, everywhere
from hairpipe.sim.models.chain import Chain
from hairpipe.sim.models.network import Network
from hairpipe.sim.motion import Motion, Step
from hairpipe.sim.stage import Rule
from hairpipe.sim.surroundings import Stage, Surroundings


@dataclass(frozen=True, eq=False)
class BackwardEuler:
    """The fast mode: one solve a step."""

    rule: Rule

    def advance(self, model: Network | Chain, motion: Motion, step: Step, around: Surroundings) -> None:
        """Advance motion by step, in place."""
        before, v0 = motion.x.copy(), motion.v.copy()
        around.begin(motion, step)
        ends = step.ends(1.0)
        motion.v[:] = along_with_roots(model, before, ends, step.dt)
        weights = everywhere(model, v0, step.dt)
        stage = Stage(before, v0, before, v0, ends, step.held, weights, step.time + step.dt, step.dt)
        kick = around.solve(motion.x, motion.v, motion.T, stage, self.rule)
        np.divide(motion.v - v0 - kick, step.dt, out=motion.a)
        around.end(motion, before, step)
