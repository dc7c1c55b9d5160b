"""TR-BDF2, linearly implicit: the trapezoidal rule to t + g dt, then second-order backward differences to t + dt.

With g = 2 - sqrt 2 both stages have the same weight h = g dt / 2 and the scheme is L-stable and of second order:

    1   xh = x + h v,        vh = v + h a,         guess v
    2   xh = w1 x1 - w0 x,   vh = w1 v1 - w0 v,    guess v1

with w1 = 1 / (g (2 - g)), w0 = (1 - g)^2 w1 and a = (v - vh) / h of the last stage, so that forces are not evaluated
again. One solve a stage, linearised at the prediction.

We differ from the paper, whose half step and trapezoid (Sec. 4) gain or lose energy at steps where this is accurate.
Source: Bank et al., Transient Simulation of Silicon Devices and Circuits, 1985; Hosea and Shampine, 1996.
"""

import numpy as np
from numba import njit

from hairpipe.sim.network import Network
from hairpipe.sim.stage import run_stage

G = 2.0 - np.sqrt(2.0)
_W1 = 1.0 / (G * (2.0 - G))
_W0 = (1.0 - G) ** 2 * _W1


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
    """Advance one block of strands by dt, in place.

    x, v, a  positions [m], velocities [m/s], accelerations of the last stage [m/s^2], (particles, 3, WIDTH)
    T        multipliers of the springs [N], (particles, 3, WIDTH)
    clamped  positions of the clamped particles at the end of each stage [m], (2, CLAMPED, 3, WIDTH)
    dt       step [s]; gravity  [m/s^2], (3,); drag  against still air [1/s]
    """
    h = G * dt / 2
    x0, v0 = x.copy(), v.copy()
    xh = x0 + h * v0
    vh = v0 + h * a
    run_stage(network, block, x, v, T, xh, vh, x0, clamped[0], h, gravity, drag)
    x1 = x.copy()
    xh = _W1 * x1 - _W0 * x0
    vh = _W1 * v - _W0 * v0
    run_stage(network, block, x, v, T, xh, vh, x1, clamped[1], h, gravity, drag)
    a[:] = (v - vh) / h
