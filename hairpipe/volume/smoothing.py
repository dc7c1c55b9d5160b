"""Smoothing of velocities on a grid that conserves momentum by exchange between neighbours.

    M_g V'_g = M_g V_g + sum_h k_gh (V_h - V_g),   k_gh = nu min(M_g, M_h),   over the six neighbours h

With nu <= 1/6, V' is a convex combination and energy never grows. We differ from Petrovic, Henne, Anderson 2005, whose
filter of V alone loses a thousandth of the momentum at the edge of hair, where a light node has a heavy neighbour.
"""

import numpy as np
from numba import njit, prange

from hairpipe.kernels.compile import inlined


@njit(cache=True, parallel=True, error_model="numpy")
def smooth(grid: np.ndarray, velocities: np.ndarray, nu: float, out: np.ndarray) -> None:
    """Write smoothed velocities of nodes, (nx, ny, nz, 3) [m/s], to out, in place.

    grid  whose first number at a node is its mass, (nx, ny, nz, 4)
    """
    for i in prange(grid.shape[0]):
        for j in range(grid.shape[1]):
            for k in range(grid.shape[2]):
                x, y, z = velocities[i, j, k, 0], velocities[i, j, k, 1], velocities[i, j, k, 2]
                mass = grid[i, j, k, 0]
                sx, sy, sz = 0.0, 0.0, 0.0
                if mass > 0.0:
                    for axis in range(3):
                        for side in range(-1, 2, 2):
                            a, b, c = _neighbour(i, j, k, axis, side)
                            if _is_inside(grid, a, b, c):
                                # k_gh / M_g, by the lighter of the two: what one gives the other gets.
                                share = nu * min(1.0, grid[a, b, c, 0] / mass)
                                sx += share * (velocities[a, b, c, 0] - x)
                                sy += share * (velocities[a, b, c, 1] - y)
                                sz += share * (velocities[a, b, c, 2] - z)
                out[i, j, k, 0], out[i, j, k, 1], out[i, j, k, 2] = x + sx, y + sy, z + sz


@inlined
def _neighbour(i, j, k, axis, side):
    return i + (side if axis == 0 else 0), j + (side if axis == 1 else 0), k + (side if axis == 2 else 0)


@inlined
def _is_inside(grid, a, b, c):
    return 0 <= a < grid.shape[0] and 0 <= b < grid.shape[1] and 0 <= c < grid.shape[2]
