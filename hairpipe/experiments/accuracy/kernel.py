"""The springs of a strand as they are, without a step of time."""

import numpy as np
from numba import njit

from hairpipe.sim.banded import row_size
from hairpipe.sim.models.interface import add_forces
from hairpipe.sim.models.network import Network


@njit(cache=True)
def spring_forces(model: Network, x: np.ndarray) -> np.ndarray:
    """Forces of the first block's springs [N], (particles, 3, W), at positions x [m] of the same shape."""
    A = np.zeros((x.shape[0], row_size(model.shape.reach), x.shape[2]))
    b, v, T = np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    for p in range(x.shape[0]):
        add_forces(model, A, b, x, v, T, p, 0, 1.0, 0.0, 0.0)
    return b
