"""Stability of a strand: the exact second derivatives of its energy, banded.

The matrix of a step omits the indefinite terms, which decide on stability: the forces of the kernels are differentiated
numerically. Particles farther apart than twice the reach of a force are moved at once: 2 reach + 1 colours, each in
three directions, are all columns.

A model whose matrix may be indefinite has exact second derivatives: their pivots are tested.

At an exchange of altitude springs forces have a kink, or a jump unless they are at rest: the step of a difference must
not reach it.
"""

import numpy as np
from numba import njit, prange

from hairpipe.geometry.banded import add
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import fill, load, minimum, select, store
from hairpipe.solve.band import eliminate, fix_root, row_size, start_row
from hairpipe.solve.stage import Iterate, System
from hairpipe.strands.interface import StiffnessPart, Terms, add_forces, shape_of

_EXACT = int(StiffnessPart.exact)
_WEIGHTS = np.array([3 / 4, -3 / 20, 1 / 60])
"""Central differences of sixth order."""


@njit(cache=True)
def _set_forces(model, block, A, b, x, still, slack):
    """Set b to the forces of a block's springs; still and slack are zero, and nothing but zeros is added to A."""
    fill(b, 0.0)
    for p in range(x.shape[0]):
        add_forces(model, System(A, b), Iterate(x, still, slack), p, block, Terms(1.0, 0.0, 0.0, 0))


@inlined
def _add_column(H, slope, p, c, reach):
    """Add the decrease of forces as particle p moves along c, half to each of the two places of an entry."""
    i = 3 * p + c
    for j in range(3 * max(0, p - reach), 3 * min(slope.shape[0], p + reach + 1)):
        half = -0.5 * load(slope, (j // 3, j % 3))
        add(H, min(i, j), abs(i - j), half + half if i == j else half)


@njit(cache=True)
def tangent(model, block, x, steps) -> np.ndarray:
    """Differentiate the energy of a block twice [N/m], (3 particles, 3 reach + 3, W): H[i, k] couples i and i + k.

    x      positions [m], (particles, 3, W)
    steps  of the differences for all strands [m], (blocks, W)
    """
    count = x.shape[0]
    reach = shape_of(model).reach
    H = np.zeros((3 * count, 3 * reach + 3, x.shape[2]), x.dtype)
    A = np.zeros((count, row_size(shape_of(model)), x.shape[2]), x.dtype)
    still, slack = np.zeros_like(x), np.zeros_like(x)
    moved = x.copy()
    slope = np.empty_like(x)
    b = np.empty_like(x)
    step = load(steps, (block,))
    for colour in range(2 * reach + 1):  # Particles of a colour have no force in common, and are moved at once.
        for c in range(3):
            fill(slope, 0.0)
            for side in range(6):
                sign = 1.0 - 2.0 * (side % 2)
                far = side // 2 + 1
                for p in range(colour, count, 2 * reach + 1):
                    store(moved, (p, c), load(x, (p, c)) + sign * far * step)
                _set_forces(model, block, A, b, moved, still, slack)
                weight = sign * _WEIGHTS[far - 1] / step
                for p in range(count):
                    for d in range(3):
                        store(slope, (p, d), load(slope, (p, d)) + weight * load(b, (p, d)))
            for p in range(colour, count, 2 * reach + 1):
                store(moved, (p, c), load(x, (p, c)))
                _add_column(H, slope, p, c, reach)
    return H


@njit(cache=True, parallel=True)
def find_stable(model, x, steps, stable) -> None:
    """Set stable to 1 where a strand is stiff against every motion of its free particles, else to 0, in place.

    x       positions of all rows [m]
    steps   of the differences [m], (blocks, W)
    stable  (blocks, W)
    """
    for block in prange(len(model.first) - 1):
        # Numba counts blocks without sign, and would compile all below for that once more.
        _find_stable(model, np.int64(block), x, steps, stable)


@njit(cache=True, error_model="numpy")
def _find_stable(model, block, x, steps, stable):
    """Eliminate all unknowns: H is positive definite where all pivots are positive."""
    rows = x[model.first[block] : model.first[block + 1]]
    clamped = shape_of(model).clamped
    H = tangent(model, block, rows, steps)
    store(stable, (block,), 1.0)
    for i in range(3 * clamped, H.shape[0]):
        pivot = load(H, (i, 0))
        store(stable, (block,), select(pivot > 0.0, load(stable, (block,)), 0.0))  # False for NaN, too.
        for k in range(1, min(H.shape[1], H.shape[0] - i)):
            part = load(H, (i, k)) / pivot
            for m in range(k, min(H.shape[1], H.shape[0] - i)):
                store(H, (i + k, m - k), load(H, (i + k, m - k)) - part * load(H, (i, m)))


@njit(cache=True)
def assemble(model, block, x, T, part):
    """Return the matrix of a block without inertia, banded as in `band.py`, and its forces, (rows, unknowns, W).

    x, T  positions [m], and stored values of the model
    part  of the stiffness, a StiffnessPart
    """
    count = x.shape[0]
    A = np.empty((count, row_size(shape_of(model)), x.shape[2]), x.dtype)
    b = np.zeros((count, shape_of(model).unknowns, x.shape[2]), x.dtype)
    still = np.zeros_like(x)
    for p in range(count):
        start_row(model, A, p, count)
    for p in range(count):  # A second pass: forces of a row are added to cleared rows after it.
        add_forces(model, System(A, b), Iterate(x, still, T), p, block, Terms(1.0, 1.0, 0.0, part))
    return A, b


@njit(cache=True, parallel=True)
def find_stable_by_pivots(model, x, T, stable) -> None:
    """Set stable to 1 where every pivot of a strand's own second derivatives is positive, else to 0, in place.

    x, T    of all rows, see `assemble`
    stable  (blocks, W)
    """
    for block in prange(len(model.first) - 1):
        # Numba counts blocks without sign, and would compile all below for that once more.
        _find_stable_by_pivots(model, np.int64(block), x, T, stable)


@njit(cache=True, error_model="numpy")
def _find_stable_by_pivots(model, block, x, T, stable):
    rows = slice(model.first[block], model.first[block + 1])
    A, b = assemble(model, block, x[rows], T[rows].copy(), _EXACT)
    count = b.shape[0]
    one = 0.0 * load(stable, (block,)) + 1.0
    lowest = one, one
    for p in range(count):
        if p < shape_of(model).clamped:
            lowest = fix_root(model, A, b, p, count, lowest)
        else:
            lowest = eliminate(model, A, b, p, count, lowest)
    store(stable, (block,), select(minimum(lowest[0], lowest[1]) > 0.0, one, 0.0))
