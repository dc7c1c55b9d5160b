"""Stretch of strands: tensions of their springs, and strands lost in a step.

The strain limit at the end of a step, and strands that corrections stretched or shortened.

A fibre hardly stretches: half a percent is a tension of 0.005 E A, thousands of times the weight of a hair. After such
a correction the forces of the step are not those at its end.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import any_lane, both, either, load, select, sqrt, store
from hairpipe.laws.strain_limit import limit_strain
from hairpipe.laws.stretch import tension
from hairpipe.solve.interactions import Interaction
from hairpipe.strands.interface import StrandModel, shape_of, spring_constant, springs_from


@inlined
def overstrained(model, x, block, limit):
    """Lanes with an axis edge whose strain is beyond +-limit, or with a particle on it that is not finite."""
    first = model.first[block]
    stride = shape_of(model).stride
    within = load(x, (0, 0)) <= load(x, (0, 0))
    for p in range(shape_of(model).before, x.shape[0] - stride - shape_of(model).after, stride):
        dx = load(x, (p + stride, 0)) - load(x, (p, 0))
        dy = load(x, (p + stride, 1)) - load(x, (p, 1))
        dz = load(x, (p + stride, 2)) - load(x, (p, 2))
        inverse_rest = load(model.inverse_lengths, (first + p, stride - 1))
        strain = sqrt(dx * dx + dy * dy + dz * dz) * inverse_rest - 1.0
        # What is not a number is beyond every limit: no comparison with it holds.
        within = both(within, both(strain <= limit, -strain <= limit))
    zero = 0.0 * load(model.mass, (first,))  # Made of masses: one made of positions that are not finite would be NaN.
    return select(within, zero, zero + 1.0) > zero


@njit(cache=True, error_model="numpy")
def set_tensions(model, block, x, T):
    """Set T to the tensions of the present stretch of a block [N], in place.

    x  (particles, 3, W); T  (particles, springs, W)
    """
    first = model.first[block]
    count = x.shape[0]
    for p in range(count):
        for o in range(1, springs_from(model, p, count) + 1):
            k = spring_constant(model, block, p, o)
            store(T, (p, o - 1), tension(x, p, o, k, load(model.inverse_lengths, (first + p, o - 1))))


@njit(cache=True, parallel=True)
def set_all_tensions(model, x, T):
    """Set T to the tensions of the present stretch of all strands [N], in place."""
    for block in prange(len(model.first) - 1):
        rows = slice(model.first[block], model.first[block + 1])
        set_tensions(model, np.int64(block), x[rows], T[rows])


@njit(cache=True, parallel=True)
def lost_lanes(model, x, limit, out):
    """Set out, (blocks, W), to 1 for strands with an edge strained beyond +-limit, in place; return whether any is."""
    for block in prange(len(model.first) - 1):
        _mark_lost(model, np.int64(block), x, limit, out)
    return out.any()


@njit(cache=True, error_model="numpy")
def _mark_lost(model, block, x, limit, out):
    rows = slice(model.first[block], model.first[block + 1])
    lanes = overstrained(model, x[rows], block, limit)
    store(out, (block,), select(lanes, 0.0 * load(out, (block,)) + 1.0, 0.0))


STRETCH = 0.1
"""Largest stretch of a segment by corrections of its ends, over its length, and over the strain limit after a step."""


@dataclass(frozen=True, eq=False)
class StrainFilter(Interaction):
    """The strain limit at the end of a step.

    model      of the strands
    tolerance  largest stretch of a segment, over its rest length
    """

    in_solve: ClassVar[bool] = False
    model: StrandModel
    tolerance: float

    def limit(self, x: np.ndarray, held: np.ndarray, excess: float = 0.0) -> None:
        """Limit the strain of hair, in place, except of strands held at both ends."""
        most = (1.0 + self.tolerance) * (1.0 + excess)
        limits = np.full((len(self.model.first) - 1, x.shape[2]), most, x.dtype)
        if len(held):
            limits[held > 0.0] = np.inf
        limit_all(self.model, x, limits)


@njit(cache=True, parallel=True)
def limit_all(model, x, limits):
    """Limit the strain of all hair, in place."""
    for block in prange(len(model.first) - 1):
        rows = slice(model.first[block], model.first[block + 1])
        limit_strain(x[rows], model.inverse_lengths[rows], shape_of(model), load(limits, (np.int64(block),)))


LENGTH_JUMP = 5e-3
"""Change of a segment's length, over its length at rest."""


@njit(cache=True, parallel=True)
def mark_length_jumps(model, before, after, out):
    """Set out, (blocks, W), to 1 for strands with a segment whose length jumped by more than `LENGTH_JUMP`, in place.

    before, after  positions [m], (rows, 3, W)
    """
    for block in prange(len(model.first) - 1):
        rows = slice(model.first[block], model.first[block + 1])
        _mark_block(model, np.int64(block), before[rows], after[rows], out)


@njit(cache=True, error_model="numpy")
def _mark_block(model, block, before, after, out):
    first = model.first[block]
    stride = shape_of(model).stride
    jumped = load(before, (0, 0)) < load(before, (0, 0))
    for p in range(shape_of(model).before, before.shape[0] - stride - shape_of(model).after, stride):
        inverse_rest = load(model.inverse_lengths, (first + p, stride - 1))
        change = (_length(after, p, p + stride) - _length(before, p, p + stride)) * inverse_rest
        jumped = either(jumped, either(change > LENGTH_JUMP, change < -LENGTH_JUMP))
    if any_lane(jumped):  # Marks are only added: lanes may have one already.
        store(out, (block,), select(jumped, 0.0 * load(out, (block,)) + 1.0, load(out, (block,))))


@njit(cache=True)
def _length(x, p, q):
    dx, dy, dz = load(x, (q, 0)) - load(x, (p, 0)), load(x, (q, 1)) - load(x, (p, 1)), load(x, (q, 2)) - load(x, (p, 2))
    return sqrt(dx * dx + dy * dy + dz * dz)
