"""External forces on points as the rows that `sim/solve/implicit_stage.py` adds to the system of every strand.

Forces push - damping v [N] become an impulse and its matrix over the weight h of a stage's end,

    h (push - damping v) + received,   h damping + diagonal,   following

where `received` is the impulse from other strands, with its own blocks: see `sim/contact/hair/couplings.py`.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.sim.axis import Axis

ROWS, ROWS_WITH_NEXT = 9, 15
"""Numbers of a point: an impulse and a block; those and the block between it and the next on the axis."""
_CHUNK = 4096


class ExternalTerms(NamedTuple):
    """External forces on points in a solve.

    push       [N], (P, 3)
    damping    symmetric, xx xy xz yy yz zz [kg/s], (P, 6)
    received   impulses from other strands [N s], (P, 3); no rows if strands are not coupled
    diagonal   block of the couplings between a point and itself [kg], (P, 6) float32; no rows likewise
    following  block between a point and the next of its strand [kg], (P, 6) float32; no rows likewise
    """

    push: np.ndarray
    damping: np.ndarray
    received: np.ndarray
    diagonal: np.ndarray
    following: np.ndarray


@njit(cache=True, parallel=True)
def clear(active: np.ndarray, push: np.ndarray, damping: np.ndarray) -> None:
    """Set push (P, 3) and damping (P, 6) of active points, (P,) bool, to zero, in place."""
    for chunk in prange(-(-len(active) // _CHUNK)):
        for k in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(active))):
            if active[k]:
                push[k] = 0.0
                damping[k] = 0.0


@njit(cache=True, parallel=True)
def copy_active(active: np.ndarray, values: np.ndarray, out: np.ndarray) -> None:
    """Set out, (P, 3), of active points, (P,) bool, to values, in place."""
    for chunk in prange(-(-len(active) // _CHUNK)):
        for k in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(active))):
            if active[k]:
                for c in range(3):
                    out[k, c] = values[k, c]


@njit(cache=True, parallel=True)
def add_impulses(impulses: np.ndarray, out: np.ndarray) -> None:
    """Add impulses [N s] to out, both (P, 3), in place."""
    for k in prange(len(out)):
        for c in range(3):
            out[k, c] += impulses[k, c]


@njit(cache=True, parallel=True)
def set_contact_dv(active: np.ndarray, impulses: np.ndarray, masses: np.ndarray, out: np.ndarray) -> None:
    """Set out, (P, 3) [m/s], of active points, (P,) bool, to impulses [N s] over masses [kg], (P,), in place."""
    for chunk in prange(-(-len(active) // _CHUNK)):
        for k in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(active))):
            if active[k]:
                for c in range(3):
                    out[k, c] = impulses[k, c] / masses[k]


@njit(cache=True, parallel=True)
def lay_out(axis: Axis, active, terms: ExternalTerms, velocities, weights, outer) -> None:
    """Write the rows of active strands, (blocks, W), in place.

    velocities  velocities v of points [m/s], (P, 3)
    weights     weight h of the end of the stage, for every strand [s], (blocks, W)
    outer       (rows / stride, 9 or 15, W)
    """
    for block in prange(len(axis.first) - 1):
        if active[block].any():
            _lay_out_block(axis, np.int64(block), terms, velocities, weights, outer)


@njit(cache=True)
def _lay_out_block(axis, block, terms, velocities, weights, outer):
    push, damping, received, diagonal, following = terms
    touching = len(received) > 0
    for lane in range(axis.strands.shape[1]):
        strand = axis.strands[block, lane]
        row = axis.first[block] // axis.stride  # `outer` has rows for the points of the axis only.
        h = weights[block, lane]
        for k in range(axis.offsets[strand], axis.offsets[strand + 1]):
            d = damping[k]
            x = velocities[k, 0]
            y = velocities[k, 1]
            z = velocities[k, 2]
            outer[row, 0, lane] = h * (push[k, 0] - d[0] * x - d[1] * y - d[2] * z)
            outer[row, 1, lane] = h * (push[k, 1] - d[1] * x - d[3] * y - d[4] * z)
            outer[row, 2, lane] = h * (push[k, 2] - d[2] * x - d[4] * y - d[5] * z)
            for c in range(6):
                outer[row, 3 + c, lane] = h * d[c]
            if touching:
                for c in range(3):  # Already impulses: they are not multiplied by h.
                    outer[row, c, lane] += received[k, c]
                for c in range(6):
                    outer[row, 3 + c, lane] += diagonal[k, c]
                    outer[row, 9 + c, lane] = following[k, c]
            row += 1
