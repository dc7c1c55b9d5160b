"""Stretch of strands: tensions of their springs, and strands lost in a step."""

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import both, load, select, sqrt, store
from hairpipe.laws.stretch import tension
from hairpipe.strands.interface import shape_of, spring_constant, springs_from


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
