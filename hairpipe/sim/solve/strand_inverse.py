"""Response of strands to impulses on their axes, by the factors of each system."""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import both, load, select, store
from hairpipe.kernels.simd_arrays import fill
from hairpipe.sim.axis import Axis
from hairpipe.sim.strands.band import forward, substitute
from hairpipe.sim.strands.interface import shape_of


@njit(cache=True, parallel=True)
def respond(model, axis: Axis, system, held, active, impulses, change) -> None:
    """Solve every strand's own system for impulses on its axis, in place.

    system    A: factors of `factor_stages`, in single precision since reading them dominates the time
              b: the change of all particles is added to it [m/s], (rows, unknowns, W); skipped if it has no rows
    held      see `Step`
    active    1 for strands to solve, (blocks, W); the others do not move
    impulses  [N s], (P, 3)
    change    out: change of the velocity of points [m/s], (P, 3)
    """
    for block in prange(len(axis.first) - 1):
        _respond_block(model, axis, np.int64(block), system, held, active, impulses, change)


@njit(cache=True, error_model="numpy")
def _respond_block(model, axis, block, system, held, active, impulses, change):
    rows = slice(axis.first[block], axis.first[block + 1])
    As = system.A[rows]
    b = system.b
    x = np.empty((As.shape[0], shape_of(model).unknowns, As.shape[2]), active.dtype)
    count = x.shape[0]
    clamped = shape_of(model).clamped
    fill(x, 0.0)
    if active[block].any():
        _take(axis, block, impulses, x)
        for p in range(clamped):  # The root is held: impulses on it are taken by the body.
            for c in range(3):
                store(x, (p, c), 0.0)
        for p in range(clamped, count):
            # Cleared just before the row is eliminated, so that an impulse on a held particle reaches no later row.
            free = load(active, (block,)) > 0.0
            if len(held) > 0 and p >= count - clamped:
                free = both(free, load(held, (block,)) < 0.5)
            for c in range(3):
                store(x, (p, c), select(free, load(x, (p, c)), 0.0))
            forward(model, As, x, p, count)
        substitute(model, As, x, count)
        if b.shape[0] > 0:
            bs = b[rows]
            for p in range(count):
                for c in range(shape_of(model).unknowns):
                    store(bs, (p, c), load(bs, (p, c)) + load(x, (p, c)))
    _give(axis, block, x, change)


@inlined
def _take(axis, block, points, x):
    """Copy what points of a block have to its particles."""
    for lane in range(axis.strands.shape[1]):
        first = axis.offsets[axis.strands[block, lane]]
        row = axis.root
        for k in range(first, axis.offsets[axis.strands[block, lane] + 1]):
            for c in range(3):
                x[row, c, lane] = points[k, c]
            row += axis.stride


@inlined
def _give(axis, block, x, points):
    """Copy what particles of a block have to its points."""
    for lane in range(axis.strands.shape[1]):
        if not axis.idle[block, lane]:  # An idle lane repeats a strand: its points are written once only.
            first = axis.offsets[axis.strands[block, lane]]
            row = axis.root
            for k in range(first, axis.offsets[axis.strands[block, lane] + 1]):
                for c in range(3):
                    points[k, c] = x[row, c, lane]
                row += axis.stride
