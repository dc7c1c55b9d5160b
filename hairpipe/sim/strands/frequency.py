"""A bound on the highest frequency of the springs of a strand, which limits an explicit step.

    w^2 <= max_p sum_s 4 k_s / (m_p l0_s),   over the springs s at a free particle p

Source: Gershgorin's theorem on M^-1 K, with k/l0 the stiffness of a spring at rest along its direction.
"""

import numpy as np
from numba import njit

from hairpipe.kernels.simd import store
from hairpipe.sim.strands.interface import StrandModel, shape_of, spring_constant, springs_from


def highest_frequency(model: StrandModel) -> float:
    """Bound the angular frequency of springs [rad/s]."""
    return float(np.sqrt(stiffest_springs(model)[0]))


@njit(cache=True)
def stiffest_springs(model):
    """Find the largest sum of 4 k / (m l0) over the springs at a free particle [1/s^2], its block and lane."""
    stiffest, where, which = 0.0, 0, 0
    for block in range(len(model.first) - 1):
        first = model.first[block]
        count = model.first[block + 1] - model.first[block]
        sums = np.zeros((count, model.mass.shape[1]))
        k = np.empty((1, model.mass.shape[1]), model.mass.dtype)
        for p in range(count):
            for o in range(1, springs_from(model, p, count) + 1):
                store(k, (0,), spring_constant(model, block, p, o))
                stiffness = 4.0 * k[0] * model.inverse_lengths[first + p, o - 1]
                sums[p] += stiffness / model.mass[first + p]
                sums[p + o] += stiffness / model.mass[first + p + o]
        for lane in range(sums.shape[1]):
            most = sums[shape_of(model).clamped :, lane].max()  # Held particles do not swing.
            if most > stiffest:
                stiffest, where, which = most, block, lane
    return stiffest, where, which
