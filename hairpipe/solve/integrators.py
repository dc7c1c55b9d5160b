"""Linearly implicit time integrators: TR-BDF2, which is the default, BDF2, and backward Euler.

TR-BDF2 is the trapezoidal rule to t + g dt, then second-order backward differences to t + dt.

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

BDF2, second-order backward differences, has one solve a step:

    xh = w1 x^n - w0 x^n-1,  vh = w1 v^n - w0 v^n-1,  h = (1 + r) / (1 + 2 r) dt,  guess v^n

with r = dt / dt_before, w1 = (1 + r)^2 / (1 + 2 r), w0 = r^2 / (1 + 2 r). It uses the previous step, which is not
stored at frames: the first step of a frame is one of TR-BDF2, so that a frame needs no more state than that scheme,
and with one step per frame the two are equal. Forces between strands are not part of the differences; a strand whose
forces jumped takes its next step by backward Euler, in one system with the others, as in TR-BDF2.

Backward Euler has one solve a step, and no history:

    M (v - v^n) = dt f(x^n + dt v),   linearised at x^n

With springs implicit along their direction only (`printed`) it is the fast mode: bounded at any step, accurate up to
about 1/120 s for long hair. Strands that the motion of their root strains are solved twice, see `Rule.guard`: a
prediction that moved them with their roots would avoid this, but would query body and hair at wrong positions. With
the tension of the present stretch it never diverges, but a swing loses most of its energy.

The nine steps of Sec. 4 of Selle, Lentine, Fedkiw 2008, after Sifakis et al. 2007.

    1  v* = v^n + dt/2 a(x^n, v*)                       4  x^n+1 = x^n + dt v*
    2  strain limiting changes v*                       5  body collisions change x^n+1 and v^n
    3  repulsions between hairs change v*               6  collisions between hairs change x^n+1 and v^n
    7  vh = v^n + dt/2 a(x^n+1/2, vh),  x^n+1/2 = (x^n + x^n+1) / 2
    8  v^n+1 = 2 vh - v^n                               9  repulsions between hairs change v^n+1

v* moves the hair and is discarded. Solves are implicit according to the spring form, linearised at the known
positions. The authors' archived code has full backward Euler at x^n+1 for 7 and 8, the other choice here.

Steps 3, 5, 6 and 9 are those of `contact/`; points that touched the body in 5 have their normal component held in
7. So resting hair has no velocity into the body before 5, and friction there, in proportion to the velocity removed,
reduces the displacement of hair in a step but not its velocity. Wind and stiction are forces of 1 and 7.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np

from hairpipe.geometry.simd import combine_all, copied
from hairpipe.solve.integrator import ContactChange, add_change, everywhere, restart_fresh, rows_of, sum_changes
from hairpipe.solve.lost import begin, hold_broken, recover, strain_of_loss
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
