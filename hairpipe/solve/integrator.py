"""Interface of time integrators.

Restart of strands whose forces have jumped: their last acceleration is not valid for the next step.

Their first stage is one of backward Euler over the whole stage of the others,

    xh = x,   vh = v,   weight of the end: the whole of the stage

in one system with the strands that they touch, which have their own weights. Forces jump if contact with the body
began or ended in a step, or moved a point out of the body at its end, or if a correction after the solves stretched or
relieved a strand (`stretch.py`).
"""

from typing import Protocol

import numpy as np
from numba import njit, prange

from hairpipe.geometry.simd import combine_all
from hairpipe.solve.stage import State, Step
from hairpipe.solve.surroundings import Surroundings
from hairpipe.strands.interface import StrandModel


class Integrator(Protocol):
    """Carries hair through a step: solves with what surrounds it, and filters where its scheme has them."""

    def advance(self, model: StrandModel, state: State, step: Step, around: Surroundings) -> None:
        """Advance state by step, in place."""
        ...


def everywhere(model: StrandModel, like: np.ndarray, number: float) -> np.ndarray:
    """Return a number for every strand, (blocks, W), of the dtype of (rows, 3, W)."""
    return np.full((len(model.first) - 1, like.shape[2]), number, like.dtype)


def rows_of(model: StrandModel, lanes: np.ndarray) -> np.ndarray:
    """Repeat what every strand has, (blocks, W), for its particles, (rows, 1, W)."""
    return np.repeat(lanes, np.diff(model.first), axis=0)[:, None]


ContactChange = np.ndarray | float
"""Change of velocity that contact made, no part of an acceleration [m/s], (rows, 3, W), or 0 where nothing touches."""


def restart_fresh(
    model: StrandModel, state: State, xh: np.ndarray, vh: np.ndarray, weights: np.ndarray, whole: float
) -> np.ndarray:
    """Set a stage of backward Euler for fresh strands: changes xh and vh, in place.

    state    state at the start of the step
    xh, vh   those of the stage of the others, (rows, 3, W)
    weights  weights of its end [s], (blocks, W)
    whole    weight of the end for fresh strands, the duration of the stage [s]

    Returns the weights of all strands.
    """
    if state.fresh.any():
        _copy_strands(model.first, state.fresh, state.x, xh)
        _copy_strands(model.first, state.fresh, state.v, vh)
    return np.where(state.fresh, whole, weights).astype(weights.dtype)


@njit(cache=True, parallel=True)
def _copy_strands(first, marked, values, out):
    """Set out, (rows, k, W), of marked strands, (blocks, W) bool, to values, in place."""
    for block in prange(len(first) - 1):
        for lane in range(marked.shape[1]):
            if marked[block, lane]:
                for row in range(first[block], first[block + 1]):
                    for c in range(out.shape[1]):
                        out[row, c, lane] = values[row, c, lane]


def take_over(model: StrandModel, state: State, other: State, active: np.ndarray) -> None:
    """Set the state of active strands, (blocks, W), to another one, in place."""
    for mine, others in ((state.x, other.x), (state.v, other.v), (state.a, other.a), (state.T, other.T)):
        _copy_strands(model.first, active != 0.0, others, mine)


def take_over_change(model: StrandModel, out: ContactChange, other: ContactChange, active: np.ndarray) -> None:
    """Set the contact change of active strands, (blocks, W), to another one, in place."""
    if isinstance(out, np.ndarray):
        np.copyto(out, other, where=rows_of(model, active != 0.0))


def add_change(out: np.ndarray, weight: float, change: ContactChange) -> None:
    """Add a contact change times a weight, in place."""
    if isinstance(change, np.ndarray):
        combine_all(out, 1.0, out, weight, change)


def sum_changes(one: ContactChange, other: ContactChange) -> ContactChange:
    """Add two contact changes; the arrays of the first are overwritten."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        combine_all(one, 1.0, one, 1.0, other)
        return one
    return other if isinstance(other, np.ndarray) else one


def lead_past_tips(model: StrandModel, state: State, held: np.ndarray) -> None:
    """Let what lies past free tips move with them, in place: q' of a rod, which has no equation.

    Contact moves points of the axis alone. Impulses that q' did not take would add up in its acceleration, with which
    a step begins, and its speed would bound the steps.

    held  1 where the tip of a strand is held, (blocks, W); no rows where all are free
    """
    if model.shape.after:
        rows = model.first[1:] - 1
        free = held[:, None, :] < 0.5 if len(held) else True
        ahead = 2.0 * state.x[rows - 1] - state.x[rows - 2]
        for values, there in ((state.x, ahead), (state.v, state.v[rows - 1]), (state.a, state.a[rows - 1])):
            values[rows] = np.where(free, there, values[rows])
