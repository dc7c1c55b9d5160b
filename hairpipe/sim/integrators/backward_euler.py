"""Backward Euler with the tension of the present stretch: damps everything, and nothing makes it diverge.

    M (v - v^n) = dt f(x^n + dt v),   linearised at x^n

A swing loses most of its energy in it; it is for the step in which a strand was thrown about so hard that the accurate
scheme lost it.
"""

import numpy as np
from numba import njit

from hairpipe.sim.network import Network
from hairpipe.sim.stage import run_stage, set_tensions


@njit(cache=True)
def step_block(
    network: Network,
    block: int,
    x: np.ndarray,
    v: np.ndarray,
    a: np.ndarray,
    T: np.ndarray,
    clamped: np.ndarray,
    dt: float,
    gravity: np.ndarray,
    drag: float,
) -> None:
    """Advance one block of strands by dt, in place; arguments as for `tr_bdf2.step_block`, without its first stage."""
    x0, v0 = x.copy(), v.copy()
    set_tensions(network, block, x, T)
    v[:] = 0.0
    run_stage(network, block, x, v, T, x0, v0, x0, clamped, dt, gravity, drag)
    a[:] = (v - v0) / dt
