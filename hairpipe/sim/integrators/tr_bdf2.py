"""TR-BDF2, linearly implicit: the trapezoidal rule to t + g dt, then second-order backward differences to t + dt.

With g = 2 - sqrt 2 both stages have the same weight h = g dt / 2 and the scheme is L-stable and of second order:

    1   xh = x + h v,        vh = v + h a,         guess v
    2   xh = w1 x1 - w0 x,   vh = w1 v1 - w0 v,    guess v1

with w1 = 1 / (g (2 - g)), w0 = (1 - g)^2 w1 and a = (v - vh) / h of the last stage, so that forces are not evaluated
again. One solve a stage, linearised at the prediction. A strand with an edge that is strained by more than 10 % after
that is beyond the scheme: its step is done again by backward Euler, which nothing makes diverge.

What strands do to each other changes velocities within a stage as backward Euler would: it is taken out of v - vh and
of v1 - v, so that no stage throws back what the one before has stopped. Where contact with the body began or ended in a
step, or moved a point out at its end, as it does with what is pressed on it, or where what came after its solves
stretched or relieved a strand (`length_jump.py`), the acceleration says nothing about the next one and is NaN;
there the first stage is one of backward Euler,

    1   xh = x,   vh = v,   weight g dt

in one system with the strands that it touches, which have weights of their own.

We differ from the paper, whose half step and trapezoid (Sec. 4) gain or lose energy at steps where this is accurate.
Source: Bank et al., Transient Simulation of Silicon Devices and Circuits, 1985; Hosea and Shampine, 1996.
"""

from dataclasses import dataclass

import numpy as np

from hairpipe.kernels.simd_arrays import combine_all, copied
from hairpipe.sim.integrators.interface import everywhere, rows_of
from hairpipe.sim.solve.implicit_stage import overstrained_lanes, set_all_tensions
from hairpipe.sim.solve.spring_form import SpringForm
from hairpipe.sim.solve.stage import Rule, Stage
from hairpipe.sim.state import State, Step
from hairpipe.sim.strands.interface import StrandModel
from hairpipe.sim.surroundings import Surroundings

G = 2.0 - np.sqrt(2.0)
_W1 = 1.0 / (G * (2.0 - G))
_W0 = (1.0 - G) ** 2 * _W1
_LOST = 0.1  # an edge strained by more than this after a solve means that the step was beyond the scheme
_MULTIPLIER = int(SpringForm.multiplier)


@dataclass(frozen=True, eq=False)
class TrBdf2:
    """The default integrator: two solves a step."""

    rule: Rule

    def advance(self, model: StrandModel, state: State, step: Step, around: Surroundings) -> None:
        """Advance state by step, in place."""
        self.take_step(model, state, step, around)

    def take_step(self, model: StrandModel, state: State, step: Step, around: Surroundings) -> np.ndarray | float:
        """Advance state by step, in place; return the change of velocity by contact [m/s], (rows, 3, W), or 0."""
        x, v, T, dt = state.x, state.v, state.T, step.dt
        x0, v0, h = copied(x), copied(v), G * dt / 2
        around.begin(state, step)
        xh, vh = np.empty_like(x), np.empty_like(x)
        combine_all(xh, 1.0, x0, h, v0)
        combine_all(vh, 1.0, v0, h, state.a)
        weights = begin_anew(model, state, xh, vh, everywhere(model, x, h), G * dt)
        stage = Stage(xh, vh, x0, v, step.ends(G), step.held, weights, step.time + G * dt, G * dt)
        first = around.solve(x, v, T, stage, self.rule)
        x1 = copied(x)
        combine_all(xh, _W1, x1, -_W0, x0)
        combine_all(vh, _W1, v, -_W0, v0)
        _add(vh, -_W0, first)
        weights = everywhere(model, x, h)
        stage = Stage(xh, vh, x1, v, step.ends(1.0), step.held, weights, step.time + dt, (1.0 - G) * dt)
        second = around.solve(x, v, T, stage, self.rule)
        combine_all(state.a, 1 / h, v, -1 / h, vh)
        _add(state.a, -1 / h, second)
        lost = everywhere(model, x, 0.0)
        if overstrained_lanes(model, x, _LOST, lost):
            kick = self._do_again(model, state, x0, v0, lost, step, around)
            _take_kick(model, first, 0.0, lost)
            _take_kick(model, second, kick, lost)
        changed = around.end(state, x0, step)
        forget(model, state.a, around.discontinuous(x))
        return _sum(_sum(first, second), changed)

    def _do_again(
        self,
        model: StrandModel,
        state: State,
        x0: np.ndarray,
        v0: np.ndarray,
        lost: np.ndarray,
        step: Step,
        around: Surroundings,
    ) -> np.ndarray | float:
        """Do the step of lost strands, (blocks, W), by backward Euler with the tension of the present stretch.

        x0, v0  where it began [m], [m/s], (rows, 3, W)

        It is linearised where they would be if they went along with their roots; the others are where they have come.

        Returns the change of velocity by contact, see `Surroundings.solve`.
        """
        robust = self.rule._replace(form=_MULTIPLIER, guard=np.inf, iterations=1)
        again = State(copied(x0), copied(state.v), np.empty_like(x0), np.zeros_like(state.T))
        set_all_tensions(model, again.x, again.T)
        ends, who = step.ends(1.0), rows_of(model, lost != 0.0)
        root = model.shape.clamped - 1
        along = (ends[:, root] - x0[model.first[:-1] + root]) / step.dt
        np.copyto(again.v, np.repeat(along, np.diff(model.first), axis=0), where=who)
        xh, began = state.x - step.dt * state.v, copied(state.v)
        np.copyto(xh, x0, where=who)
        np.copyto(began, v0, where=who)
        weights = everywhere(model, x0, step.dt)
        stage = Stage(xh, v0, x0, began, ends, step.held, weights, step.time + step.dt, step.dt)
        kick = around.solve(again.x, again.v, again.T, stage, robust, lost)
        again.a[:] = (again.v - v0 - kick) / step.dt
        _take(model, state, again, lost, "xvaT")
        return kick


def _add(out: np.ndarray, weight: float, kick: np.ndarray | float) -> None:
    """Add what contact made so many times, in place; see `Surroundings.solve`."""
    if isinstance(kick, np.ndarray):
        combine_all(out, 1.0, out, weight, kick)


def _take_kick(model: StrandModel, out: np.ndarray | float, kick: np.ndarray | float, who: np.ndarray) -> None:
    """Take over what contact made of some strands, (blocks, W), in place."""
    if isinstance(out, np.ndarray):
        np.copyto(out, kick, where=rows_of(model, who != 0.0))


def _sum(one: np.ndarray | float, other: np.ndarray | float) -> np.ndarray | float:
    """Add two of what contact made; the first is lost."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        combine_all(one, 1.0, one, 1.0, other)
        return one
    return other if isinstance(other, np.ndarray) else one


def begin_anew(
    model: StrandModel, state: State, xh: np.ndarray, vh: np.ndarray, weights: np.ndarray, whole: float
) -> np.ndarray:
    """Let strands whose acceleration is not known do a stage of backward Euler: changes xh and vh, in place.

    state   where the step begins
    xh, vh   of the stage that the others do, (rows, 3, W)
    weights  of its end [s], (blocks, W); whole  that of backward Euler, all of the stage [s]

    Returns the weights of them all.
    """
    unknown = np.isnan(state.a[model.first[:-1] + model.shape.clamped, 0])
    if unknown.any():
        np.copyto(xh, state.x, where=rows_of(model, unknown))
        np.copyto(vh, state.v, where=rows_of(model, unknown))
    return np.where(unknown, whole, weights).astype(weights.dtype)


def forget(model: StrandModel, a: np.ndarray, shocked: np.ndarray) -> None:
    """Set the accelerations of strands that are marked, (blocks, W), to NaN, in place."""
    np.copyto(a, np.nan, where=rows_of(model, shocked != 0.0))


def _take(model: StrandModel, state: State, other: State, who: np.ndarray, names: str) -> None:
    """Take over the state of some strands, (blocks, W), in place."""
    for name in names:
        np.copyto(getattr(state, name), getattr(other, name), where=rows_of(model, who != 0.0))
