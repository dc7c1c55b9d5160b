"""TR-BDF2, linearly implicit: the trapezoidal rule to t + g dt, then second-order backward differences to t + dt.

With g = 2 - sqrt 2 both stages have the same weight h = g dt / 2 and the scheme is L-stable and of second order:

    1   xh = x + h v,        vh = v + h a,         guess v
    2   xh = w1 x1 - w0 x,   vh = w1 v1 - w0 v,    guess v1

with w1 = 1 / (g (2 - g)), w0 = (1 - g)^2 w1 and a = (v - vh) / h of the last stage, so that forces are not evaluated
again. One solve a stage, linearised at the prediction. A strand with an edge that is strained by more than 10 % after
that is beyond the scheme: its step is done again by backward Euler, which nothing makes diverge.

We differ from the paper, whose half step and trapezoid (Sec. 4) gain or lose energy at steps where this is accurate.
Source: Bank et al., Transient Simulation of Silicon Devices and Circuits, 1985; Hosea and Shampine, 1996.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from hairpipe.body.inlined import inlined
from hairpipe.sim.filters.filters import Filters
from hairpipe.sim.integrators.interface import Motion, Step
from hairpipe.sim.lanes import any_lane, load, select, store
from hairpipe.sim.models.chain import Chain
from hairpipe.sim.models.network import Network
from hairpipe.sim.rows import combine, copy, fill
from hairpipe.sim.spring_form import SpringForm
from hairpipe.sim.stage import Rule, overstrained, run_stage, set_tensions

G = 2.0 - np.sqrt(2.0)
_W1 = 1.0 / (G * (2.0 - G))
_W0 = (1.0 - G) ** 2 * _W1
_LOST = 0.1  # an edge strained by more than this after a solve means that the step was beyond the scheme
_MULTIPLIER = int(SpringForm.multiplier)


@dataclass(frozen=True, eq=False)
class TrBdf2:
    """The default integrator: two solves a step."""

    rule: Rule

    def advance(self, model: Network | Chain, motion: Motion, step: Step, filters: Filters) -> None:
        """Advance motion by step, in place."""
        before = motion.x.copy()
        ends = np.stack([step.ends(G), step.ends(1.0)])
        advance_all(model, motion.x, motion.v, motion.a, motion.T, ends, step.held, step.dt, self.rule)
        filters.finish(motion.x, motion.v, before, step.time, step.dt)


@njit(cache=True, parallel=True)
def advance_all(model, x, v, a, T, ends, held, dt, rule):  # noqa: ANN001, ANN201
    """Advance every strand by dt, in place.

    x, v, a, T  see Motion; ends  at the end of each stage, (2, blocks, 2 clamped, 3, W)
    """
    for block in prange(len(model.first) - 1):
        # Numba counts blocks without sign, and would compile all below for that once more.
        _advance(model, np.int64(block), x, v, a, T, ends, held, dt, rule)


@njit(cache=True)
def _advance(model, block, x, v, a, T, ends, held, dt, rule):  # noqa: ANN001, ANN202
    rows = slice(model.first[block], model.first[block + 1])
    xs, vs, accelerations, tensions = x[rows], v[rows], a[rows], T[rows]
    x0, v0, x1 = np.empty_like(xs), np.empty_like(xs), np.empty_like(xs)
    xh, vh = np.empty_like(xs), np.empty_like(xs)
    h = G * dt / 2
    copy(x0, xs)
    copy(v0, vs)
    combine(xh, 1.0, x0, h, v0)
    combine(vh, 1.0, v0, h, accelerations)
    run_stage(model, block, xs, vs, tensions, xh, vh, x0, ends[0, block], held, h, rule)
    copy(x1, xs)
    combine(xh, _W1, x1, -_W0, x0)
    combine(vh, _W1, vs, -_W0, v0)
    run_stage(model, block, xs, vs, tensions, xh, vh, x1, ends[1, block], held, h, rule)
    combine(accelerations, 1 / h, vs, -1 / h, vh)
    lost = overstrained(model, xs, block, _LOST)
    if any_lane(lost):
        # From the start of the step, with the tension of the present stretch.
        robust = Rule(_MULTIPLIER, rule.damping, np.inf, 1, rule.gravity, rule.drag)
        t1 = np.empty_like(tensions)
        copy(x1, x0)
        copy(t1, tensions)
        fill(vh, 0.0)
        set_tensions(model, block, x1, t1)
        run_stage(model, block, x1, vh, t1, x0, v0, x0, ends[1, block], held, dt, robust)
        combine(xh, 1 / dt, vh, -1 / dt, v0)
        _take(lost, xs, x1)
        _take(lost, vs, vh)
        _take(lost, accelerations, xh)
        _take(lost, tensions, t1)


@inlined
def _take(lost, target, source):  # noqa: ANN001, ANN202
    """Replace the flagged lanes of target by those of source, in place."""
    for p in range(target.shape[0]):
        for c in range(target.shape[1]):
            store(target, (p, c), select(lost, load(source, (p, c)), load(target, (p, c))))
