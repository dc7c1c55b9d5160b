"""What acts on points from outside as the rows that `sim/solve/implicit_stage.py` adds to the system of every strand.

Forces push - damping v [N] become an impulse and its matrix over the weight h of a stage's end,

    h (push - damping v) + received,   h damping + diagonal,   following

what other strands give being an impulse already, with blocks of its own: see `sim/contact/hair/couplings.py`.
"""

import numpy as np
from numba import njit, prange

from hairpipe.sim.axis import Axis

ROWS, ROWS_WITH_NEXT = 9, 15
"""Numbers of a point: an impulse and a block; those and the block between it and the next on the axis."""
_CHUNK = 4096


@njit(cache=True, parallel=True)
def clear(active: np.ndarray, push: np.ndarray, damping: np.ndarray) -> None:
    """Set push (P, 3) and damping (P, 6) of active points, (P,) bool, to zero, in place."""
    for chunk in prange(-(-len(active) // _CHUNK)):
        for k in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(active))):
            if active[k]:
                push[k] = 0.0
                damping[k] = 0.0


@njit(cache=True, parallel=True)
def velocity_changes(active: np.ndarray, impulses: np.ndarray, masses: np.ndarray, out: np.ndarray) -> None:
    """Set out, (P, 3) [m/s], of active points, (P,) bool, to impulses [N s] over masses [kg], (P,), in place."""
    for chunk in prange(-(-len(active) // _CHUNK)):
        for k in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(active))):
            if active[k]:
                for c in range(3):
                    out[k, c] = impulses[k, c] / masses[k]


@njit(cache=True, parallel=True)
def lay_out(axis: Axis, active, push, damping, speeds, weights, received, diagonal, following, outer) -> None:
    """Write the rows of active strands, (blocks, W), in place.

    push [N], (P, 3); damping [kg/s], symmetric, (P, 6); speeds  v [m/s], (P, 3)
    weights  h, of the end of the stage, for every strand [s], (blocks, W)
    received [N s], (P, 3); diagonal, following [kg], (P, 6); no rows where strands do not touch
    outer    (rows / stride, 9 or 15, W)
    """
    for block in prange(len(axis.first) - 1):
        if active[block].any():
            _lay_out_block(axis, np.int64(block), push, damping, speeds, weights, received, diagonal, following, outer)


@njit(cache=True)
def _lay_out_block(axis, block, push, damping, speeds, weights, received, diagonal, following, outer):
    touching = len(received) > 0
    for lane in range(axis.strands.shape[1]):
        strand = axis.strands[block, lane]
        row, h = axis.first[block] // axis.stride, weights[block, lane]
        for k in range(axis.offsets[strand], axis.offsets[strand + 1]):
            d, x, y, z = damping[k], speeds[k, 0], speeds[k, 1], speeds[k, 2]
            outer[row, 0, lane] = h * (push[k, 0] - d[0] * x - d[1] * y - d[2] * z)
            outer[row, 1, lane] = h * (push[k, 1] - d[1] * x - d[3] * y - d[4] * z)
            outer[row, 2, lane] = h * (push[k, 2] - d[2] * x - d[4] * y - d[5] * z)
            for c in range(6):
                outer[row, 3 + c, lane] = h * d[c]
            if touching:
                for c in range(3):
                    outer[row, c, lane] += received[k, c]
                for c in range(6):
                    outer[row, 3 + c, lane] += diagonal[k, c]
                    outer[row, 9 + c, lane] = following[k, c]
            row += 1
