"""Strands that a step has lost: they do it again by backward Euler.

An edge that is strained by more than 10 % after a step was beyond the scheme. So is a rod whose matrix was not positive
definite: what was solved then is no step of any scheme. (One that touches others takes what of it is, within the stage:
`solve/implicit_stage.py`.) Backward Euler with the tension of the present stretch, and with what of a rod's stiffness
is positive semidefinite, loses nothing; it is of first order, and rare.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.kernels.simd_arrays import copied
from hairpipe.sim.integrators.integrator import everywhere, rows_of
from hairpipe.sim.integrators.restart import ContactChange, take_over
from hairpipe.sim.solve.spring_form import SpringForm
from hairpipe.sim.solve.stage import Rule, Stage
from hairpipe.sim.solve.stretch import lost_lanes, set_all_tensions
from hairpipe.sim.state import State, Step
from hairpipe.sim.strands.interface import StiffnessPart, StrandModel, may_be_lost
from hairpipe.sim.surroundings import Surroundings

STRAIN = 0.1


class Began(NamedTuple):
    """Where a step began: positions [m], velocities [m/s], (rows, 3, W), and what a model that may be lost knew."""

    x: np.ndarray
    v: np.ndarray
    T: np.ndarray | None


def begin(model: StrandModel, state: State) -> Began:
    """Copy what is needed to do a step again."""
    return Began(copied(state.x), copied(state.v), copied(state.T) if may_be_lost(model) else None)


def find_lost(model: StrandModel, state: State) -> np.ndarray | None:
    """Mark the strands that the step has lost with 1, (blocks, W); None where there are none."""
    lost = everywhere(model, state.x, 0.0)
    return lost if lost_lanes(model, state.x, state.T, STRAIN, lost) else None


def do_again(
    rule: Rule, model: StrandModel, state: State, began: Began, lost: np.ndarray, step: Step, around: Surroundings
) -> ContactChange:
    """Do the step of lost strands, (blocks, W), by backward Euler with the tension of the present stretch, in place.

    It is linearised where they would be if they went along with their roots; the others are where they have come.

    Returns the change of velocity by contact, see `Surroundings.solve`.
    """
    robust = rule._replace(
        form=int(SpringForm.multiplier), guard=np.inf, iterations=1, part=int(StiffnessPart.projected)
    )
    x0, v0, T0 = began
    T = np.zeros_like(state.T) if T0 is None else copied(T0)
    again = State(copied(x0), copied(state.v), np.empty_like(x0), T, state.fresh)
    set_all_tensions(model, again.x, again.T)
    ends, who = step.ends(1.0), rows_of(model, lost != 0.0)
    root = model.shape.clamped - 1
    along = (ends[:, root] - x0[model.first[:-1] + root]) / step.dt
    np.copyto(again.v, np.repeat(along, np.diff(model.first), axis=0), where=who)
    xh, before = state.x - step.dt * state.v, copied(state.v)
    np.copyto(xh, x0, where=who)
    np.copyto(before, v0, where=who)
    weights = everywhere(model, x0, step.dt)
    stage = Stage(xh, v0, x0, before, ends, step.held, weights, step.time + step.dt, step.dt)
    kick = around.solve(again.x, again.v, again.T, stage, robust, lost)
    again.a[:] = (again.v - v0 - kick) / step.dt
    if T0 is not None:
        again.T[model.first[:-1], 1] += 1.0
    take_over(model, state, again, lost)
    return kick
