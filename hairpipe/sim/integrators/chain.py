"""A step of all strands: the accurate scheme, and the robust one for strands that it loses."""

import numpy as np
from numba import njit, prange

from hairpipe.sim.integrators import backward_euler, tr_bdf2
from hairpipe.sim.lanes import any_lane, load, select, store
from hairpipe.sim.network import Network
from hairpipe.sim.stage import overstrained

_LOST = 0.1  # an edge strained by more than this after a solve means that the step was beyond the scheme


@njit(cache=True, parallel=True)
def advance(
    network: Network,
    x: np.ndarray,
    v: np.ndarray,
    a: np.ndarray,
    T: np.ndarray,
    clamped: np.ndarray,
    dt: float,
    gravity: np.ndarray,
    drag: float,
) -> None:
    """Advance every strand by dt, in place; see `tr_bdf2.step_block`.

    x, v, a, T  (rows, 3, WIDTH)
    clamped     (2, blocks, CLAMPED, 3, WIDTH)
    """
    for block in prange(len(network.first) - 1):
        rows = slice(network.first[block], network.first[block + 1])
        xs, vs, accelerations, tensions = x[rows], v[rows], a[rows], T[rows]
        x0, v0, a0, t0 = xs.copy(), vs.copy(), accelerations.copy(), tensions.copy()
        ends = clamped[:, block].copy()
        tr_bdf2.step_block(network, block, xs, vs, accelerations, tensions, ends, dt, gravity, drag)
        lost = overstrained(xs, network.inverse_lengths[rows], _LOST)
        if any_lane(lost):
            backward_euler.step_block(network, block, x0, v0, a0, t0, ends[1], dt, gravity, drag)
            _take(lost, xs, x0)
            _take(lost, vs, v0)
            _take(lost, accelerations, a0)
            _take(lost, tensions, t0)


@njit(cache=True)
def _take(lost, target, source):  # noqa: ANN001, ANN202
    """Replace the flagged lanes of target by those of source, in place."""
    for p in range(target.shape[0]):
        for c in range(3):
            store(target, (p, c), select(lost, load(source, (p, c)), load(target, (p, c))))
