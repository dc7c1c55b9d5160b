"""Recovery of strands that a step has lost: each of them still reaches a bounded state.

A strand is lost if an edge is strained by more than 10 % after a step. (A rod whose matrix is not positive definite
takes the positive semidefinite part within the stage: `solve/implicit_stage.py`.) Lost strands repeat the step, each by
the first of these methods that succeeds:

    1  by backward Euler, with the tension of the present stretch and the positive semidefinite part of a rod's
       stiffness
    2  the same in `PARTS` shorter steps
    3  held: its shape at the start of the step is moved rigidly with its root, see `hold_broken`

1 is of first order, and rare; 2 and 3 are for strands that are not finite, or stretched beyond `BROKEN`. None of them
changes a strand that is not lost. Held strands are counted in `State.held` and reported in a warning.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.simd import copied
from hairpipe.laws.stretch import SpringForm
from hairpipe.solve.integrator import ContactChange, everywhere, rows_of, sum_changes, take_over, take_over_change
from hairpipe.solve.stage import Rule, Stage, State, Step
from hairpipe.solve.stretch import lost_lanes, set_all_tensions
from hairpipe.solve.surroundings import Surroundings
from hairpipe.strands.interface import StiffnessPart, StrandModel, may_be_lost

STRAIN = 0.1
BROKEN = 9.0
"""Strain of an edge beyond which a strand is in no state of hair: ten times its length."""
PARTS = 8
"""Shorter steps that a step is cut into for a strand that one of backward Euler loses."""


class Began(NamedTuple):
    """Start of a step: positions [m], velocities [m/s], (rows, 3, W), and the stored values of the model."""

    x: np.ndarray
    v: np.ndarray
    T: np.ndarray | None


def begin(model: StrandModel, state: State) -> Began:
    """Copy what is needed to do a step again."""
    return Began(copied(state.x), copied(state.v), copied(state.T) if may_be_lost(model) else None)


def strain_of_loss(model: StrandModel) -> float:
    """Return the strain beyond which backward differences of first or second order lose a strand.

    Only a model whose matrix may be indefinite benefits from a semidefinite matrix.
    """
    return STRAIN if may_be_lost(model) else BROKEN


def find_lost(model: StrandModel, state: State, strain: float) -> np.ndarray | None:
    """Mark the strands that the step has lost with 1, (blocks, W); None if there are none."""
    lost = everywhere(model, state.x, 0.0)
    return lost if lost_lanes(model, state.x, strain, lost) else None


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
    """Repeat the step of strands that the scheme has lost until each is in a bounded state, in place.

    changes  changes of velocity by contact in the stages; for lost strands set to that of the recovery, in the last
    strain   strain of an edge beyond which its strand is lost
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
    """Mark strands that are not finite, or stretched beyond `BROKEN`, with 1, (blocks, W); None if there are none."""
    broken = find_lost(model, state, BROKEN)
    if broken is not None and len(step.held):
        broken[are_finite(model, state.x) & (step.held > 0.0)] = 0.0
    return broken if broken is not None and broken.any() else None


def are_finite(model: StrandModel, x: np.ndarray) -> np.ndarray:
    """Find the strands whose particles, (rows, k, W), all are finite, (blocks, W) bool."""
    finite = np.ones((len(model.first) - 1, x.shape[-1]), np.bool_)
    _find_finite(model.first, x, finite)
    return finite


@njit(cache=True, parallel=True)
def _find_finite(first, x, finite):
    for block in prange(len(first) - 1):
        for row in range(first[block], first[block + 1]):
            for c in range(x.shape[1]):
                for lane in range(x.shape[2]):
                    finite[block, lane] &= np.isfinite(x[row, c, lane])


def hold_broken(model: StrandModel, state: State, began: Began, step: Step) -> None:
    """End the step of broken strands in the shape in which they began it, in place.

    They move rigidly with their roots; the gap at a held tip is distributed along the strand. Their velocity is the
    mean velocity of this motion, and they are counted in `State.held`.
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
        there = moved_rigidly(here, ends[block, :clamped, :, lane].astype(float))
        if len(step.held) and step.held[block, lane] > 0.0:
            there += np.linspace(0.0, 1.0, len(there))[:, None] * (ends[block, -1, :, lane] - there[-1])
            there[-clamped:] = ends[block, clamped:, :, lane]
        state.x[rows, :, lane], state.v[rows, :, lane] = there, (there - here) / step.dt
        state.a[rows, :, lane] = 0.0
    T = np.zeros_like(state.T) if began.T is None else copied(began.T)
    set_all_tensions(model, state.x, T)
    np.copyto(state.T, T, where=rows_of(model, broken != 0.0))


def moved_rigidly(points: np.ndarray, clamp: np.ndarray) -> np.ndarray:
    """Move the particles of a strand [m], (n, 3), rigidly so that the first of them come to a clamp [m], (c, 3); pure.

    The rotation is the least-squares fit; if all particles of a clamp lie on one axis, there is no rotation about it.
    Source: Kabsch, A solution for the best rotation to relate two sets of vectors, 1976.
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
    """Repeat the step of lost strands, (blocks, W), by backward Euler with the present tension, in place."""
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
