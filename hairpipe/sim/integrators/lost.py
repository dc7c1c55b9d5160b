"""Strands that a step has lost, and how each of them gets to a bounded state all the same.

An edge that is strained by more than 10 % after a step was beyond the scheme. So is a rod whose matrix was not positive
definite: the result then is not a step of any scheme. (One that touches others takes what of it is, within the stage:
`solve/implicit_stage.py`.) Lost strands do the step again, each as far as it needs:

    1  by backward Euler, with the tension of the present stretch and what of a rod's stiffness is positive semidefinite
    2  the same in `PARTS` shorter steps
    3  not at all: the shape in which it began the step is moved rigidly with its root, see `hold`

1 is of first order, and rare; 2 and 3 are for strands that are not finite, or stretched beyond `BROKEN`. None of them
changes a strand that is not lost. What held strands are is in `State.held`, and is warned of.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.kernels.simd_arrays import copied
from hairpipe.sim.integrators.integrator import everywhere, rows_of
from hairpipe.sim.integrators.restart import ContactChange, sum_changes, take_over, take_over_change
from hairpipe.sim.solve.spring_form import SpringForm
from hairpipe.sim.solve.stage import Rule, Stage
from hairpipe.sim.solve.stretch import lost_lanes, set_all_tensions
from hairpipe.sim.state import State, Step
from hairpipe.sim.strands.interface import StiffnessPart, StrandModel, may_be_lost
from hairpipe.sim.surroundings import Surroundings

STRAIN = 0.1
BROKEN = 9.0
"""Strain of an edge beyond which a strand is in no state of hair: ten times its length."""
PARTS = 8
"""Shorter steps that a step is cut into for a strand that one of backward Euler loses."""


class Began(NamedTuple):
    """Where a step began: positions [m], velocities [m/s], (rows, 3, W), and what a model that may be lost knew."""

    x: np.ndarray
    v: np.ndarray
    T: np.ndarray | None


def begin(model: StrandModel, state: State) -> Began:
    """Copy what is needed to do a step again."""
    return Began(copied(state.x), copied(state.v), copied(state.T) if may_be_lost(model) else None)


def strain_of_loss(model: StrandModel) -> float:
    """Return the strain beyond which backward differences of first or second order lose a strand.

    Only a model whose matrix may be indefinite is better off with a matrix that is not.
    """
    return STRAIN if may_be_lost(model) else BROKEN


def find_lost(model: StrandModel, state: State, strain: float) -> np.ndarray | None:
    """Mark the strands that the step has lost with 1, (blocks, W); None where there are none.

    strain  of an edge, beyond which its strand is lost
    """
    lost = everywhere(model, state.x, 0.0)
    return lost if lost_lanes(model, state.x, state.T, strain, lost) else None


def recover(
    rule: Rule,
    model: StrandModel,
    state: State,
    began: Began,
    step: Step,
    around: Surroundings,
    changes: tuple[ContactChange, ...],
    strain: float = STRAIN,
) -> None:
    """Do the step of strands that the scheme has lost again, until each is in a bounded state, in place.

    changes  of velocity by contact in the stages of the step; those of lost strands become that of this, in the last
    strain   of an edge, beyond which its strand is lost to the scheme
    """
    lost = find_lost(model, state, strain)
    if lost is None:
        return
    kick = do_again(rule, model, state, began, lost, step, around)
    broken = find_broken(model, state, step)
    if broken is not None:
        take_over_change(model, kick, do_again(rule, model, state, began, broken, step, around, PARTS), broken)
        hold_broken(model, state, began, step)
    for change in changes[:-1]:
        take_over_change(model, change, 0.0, lost)
    take_over_change(model, changes[-1], kick, lost)


def find_broken(model: StrandModel, state: State, step: Step) -> np.ndarray | None:
    """Mark strands that are not finite, or stretched beyond `BROKEN`, with 1, (blocks, W); None where there are none.

    How far a strand is stretched whose tip is held is up to what leads its ends.
    """
    if may_be_lost(model):
        state.T[model.first[:-1], 0] = 0.0  # what was solved by the positive semidefinite part is a step
    broken = find_lost(model, state, BROKEN)
    if broken is not None and len(step.held):
        broken[are_finite(model, state.x) & (step.held > 0.0)] = 0.0
    return broken if broken is not None and broken.any() else None


def are_finite(model: StrandModel, x: np.ndarray) -> np.ndarray:
    """Find the strands whose particles, (rows, ..., W), all are finite, (blocks, W) bool."""
    finite = np.isfinite(x).reshape(len(x), -1, x.shape[-1]).all(axis=1)
    return np.logical_and.reduceat(finite, model.first[:-1])


def hold_broken(model: StrandModel, state: State, began: Began, step: Step) -> None:
    """Let strands that are in no state of hair end the step in the shape in which they began it, in place.

    They go rigidly with their roots, those whose tip is held with a share of what this misses it by; their velocity is
    the mean one of that, and they are counted in `State.held`.
    """
    broken = find_broken(model, state, step)
    if broken is None:
        return
    state.held += broken > 0.0
    state.failed += not are_finite(model, state.x).any()
    ends = step.ends(1.0)
    clamped = model.shape.clamped
    for block, lane in np.argwhere(broken).tolist():
        rows = slice(model.first[block], model.first[block + 1])
        here = began.x[rows, :, lane].astype(float)
        there = carried_with(here, ends[block, :clamped, :, lane].astype(float))
        if len(step.held) and step.held[block, lane] > 0.0:
            there += np.linspace(0.0, 1.0, len(there))[:, None] * (ends[block, -1, :, lane] - there[-1])
            there[-clamped:] = ends[block, clamped:, :, lane]
        state.x[rows, :, lane], state.v[rows, :, lane] = there, (there - here) / step.dt
        state.a[rows, :, lane] = 0.0
    T = np.zeros_like(state.T) if began.T is None else copied(began.T)
    set_all_tensions(model, state.x, T)
    np.copyto(state.T, T, where=rows_of(model, broken != 0.0))


def carried_with(points: np.ndarray, clamp: np.ndarray) -> np.ndarray:
    """Move the particles of a strand [m], (n, 3), rigidly so that the first of them come to a clamp [m], (c, 3); pure.

    The rotation is that of least squares; about an axis on which all of a clamp lies it does not turn. Source: Kabsch,
    A solution for the best rotation to relate two sets of vectors, 1976.
    """
    before = points[: len(clamp)] - points[len(clamp) - 1]
    after = clamp - clamp[-1]
    left, _, right = np.linalg.svd(before.T @ after + 1e-9 * np.sum(before * before) * np.eye(3))
    left[:, -1] *= np.linalg.det(left @ right)
    return (points - points[len(clamp) - 1]) @ (left @ right) + clamp[-1]


def do_again(
    rule: Rule,
    model: StrandModel,
    state: State,
    began: Began,
    lost: np.ndarray,
    step: Step,
    around: Surroundings,
    parts: int = 1,
) -> ContactChange:
    """Do the step of lost strands, (blocks, W), by backward Euler with the tension of the present stretch, in place.

    It is linearised where they would be if they went along with their roots; the others are where they have come.

    parts  equal steps that it is done in

    Returns the change of velocity by contact, see `Surroundings.solve`.
    """
    robust = rule._replace(
        form=int(SpringForm.multiplier), guard=np.inf, iterations=1, part=int(StiffnessPart.projected)
    )
    x0, v0, T0 = began
    T = np.zeros_like(state.T) if T0 is None else copied(T0)
    again = State(copied(x0), copied(v0), np.empty_like(x0), T, state.fresh)
    active = rows_of(model, lost != 0.0)
    root = model.shape.clamped - 1
    dt = step.dt / parts
    weights = everywhere(model, x0, dt)
    changed = 0.0
    for part in range(1, parts + 1):
        x0 = copied(again.x)
        v0 = copied(again.v)
        ends = step.ends(part / parts)
        set_all_tensions(model, again.x, again.T)
        along = (ends[:, root] - x0[model.first[:-1] + root]) / dt
        again.v[:] = np.where(active, np.repeat(along, np.diff(model.first), axis=0), state.v)
        xh = np.where(active, x0, state.x - dt * state.v)
        before = np.where(active, v0, state.v)
        stage = Stage(xh, v0, x0, before, ends, step.held, weights, step.time + part / parts * step.dt, dt)
        kick = around.solve(again.x, again.v, again.T, stage, robust, lost)
        again.a[:] = (again.v - v0 - kick) / dt
        changed = sum_changes(changed, kick)
    if T0 is not None:
        again.T[model.first[:-1], 1] += 1.0
    take_over(model, state, again, lost)
    return changed
