"""Drag of air on the segments of strands.

The force on a segment of length L and direction d that moves with u relative to the air is (see `cylinder.py`)

    f = -L (c_n u_n + c_t u_t),   u_t = (u . d) d,   u_n = u - u_t,

half of it at each end, where u is the velocity of that end relative to the air. The coefficients are those of the mean
of both ends at the start of the solve; with them the force is linear in v, and stable for any step.
"""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined
from hairpipe.sim.air.cylinder import Law, normal_drag, tangential_drag
from hairpipe.sim.interactions import Prediction


@njit(cache=True, parallel=True, error_model="numpy")
def add_drag(
    at: Prediction,
    air: np.ndarray,
    offsets: np.ndarray,
    law: Law,
    sizes: np.ndarray,
    push: np.ndarray,
    damping: np.ndarray,
) -> None:
    """Add the force push - damping v of the air on active points, in place; values of the others are not read.

    at       a prediction: drag depends on its lagged velocities
    air      velocity of the air at every point [m/s], (P, 3)
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,) int32
    sizes    diameters of segments over the diameter of the law, (P,): a Reynolds number is proportional to its diameter
    push     [N], (P, 3); damping  symmetric xx xy xz yy yz zz [kg/s], (P, 6)
    """
    for strand in prange(len(offsets) - 1):
        end = offsets[strand + 1] if at.active[offsets[strand]] else offsets[strand]  # A strand is active as a whole.
        for k in range(offsets[strand], end - 1):  # One thread per strand: segments add to common points in order.
            _add_segment(at.points, at.lagged_velocity, air, k, law, sizes[k], push, damping)


@inlined
def _add_segment(points, velocities, air, k, law, size, push, damping):
    """Add the drag of the segment from point k to the next."""
    dx, dy, dz = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1], points[k + 1, 2] - points[k, 2]
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    if not length > 0.0:
        return
    dx, dy, dz = dx / length, dy / length, dz / length
    ux = 0.5 * (velocities[k, 0] + velocities[k + 1, 0] - air[k, 0] - air[k + 1, 0])
    uy = 0.5 * (velocities[k, 1] + velocities[k + 1, 1] - air[k, 1] - air[k + 1, 1])
    uz = 0.5 * (velocities[k, 2] + velocities[k + 1, 2] - air[k, 2] - air[k + 1, 2])
    along, squared = ux * dx + uy * dy + uz * dz, ux * ux + uy * uy + uz * uz
    across = np.sqrt(max(squared - along * along, 0.0))  # Rounding may make it negative where wind is along the hair.
    normal = 0.5 * length * normal_drag(law, size * across)
    # c_n (I - d d^T) + c_t d d^T = c_n I + (c_t - c_n) d d^T: half of it for each end.
    excess = 0.5 * length * tangential_drag(law, size * np.sqrt(squared)) - normal
    xx = normal + excess * dx * dx
    xy = excess * dx * dy
    xz = excess * dx * dz
    yy = normal + excess * dy * dy
    yz = excess * dy * dz
    zz = normal + excess * dz * dz
    for p in (k, k + 1):
        wx, wy, wz = air[p, 0], air[p, 1], air[p, 2]
        push[p, 0] += xx * wx + xy * wy + xz * wz
        push[p, 1] += xy * wx + yy * wy + yz * wz
        push[p, 2] += xz * wx + yz * wy + zz * wz
        damping[p, 0] += xx
        damping[p, 1] += xy
        damping[p, 2] += xz
        damping[p, 3] += yy
        damping[p, 4] += yz
        damping[p, 5] += zz
