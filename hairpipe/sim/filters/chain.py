"""The filters of a step, one after the other, block by block: a block that nothing touches is passed once."""

import numpy as np
from numba import njit, prange

from hairpipe.levelset.field import Field
from hairpipe.sim.filters.collide_body import collide_body
from hairpipe.sim.filters.limit_strain import limit_strain
from hairpipe.sim.network import Network

_SWEEPS = 2  # contact stretches what it pushes, and drawing that in may push it back: twice leaves a few percent


@njit(cache=True, parallel=True)
def limit_all(network: Network, x: np.ndarray, tolerance: float) -> None:
    """Limit the strain of hair that has nothing to collide with, in place; see `limit_strain`.

    x  positions [m], (rows, 3, WIDTH)
    """
    for block in prange(len(network.first) - 1):
        rows = slice(network.first[block], network.first[block + 1])
        limit_strain(x[rows], network.inverse_lengths[rows], tolerance)


@njit(cache=True, parallel=True)
def limit_and_collide(
    network: Network,
    x: np.ndarray,
    v: np.ndarray,
    before: np.ndarray,
    tolerance: float,
    field0: Field,
    field1: Field,
    frame: float,
    times: tuple[float, float],
    scheme: int,
    friction: float,
    thickness: float,
) -> None:
    """Limit strain and move hair out of the body, in place; see `limit_strain` and `collide_body`.

    x, v, before  (rows, 3, WIDTH)
    """
    for block in prange(len(network.first) - 1):
        rows = slice(network.first[block], network.first[block + 1])
        xs, vs, x0, lengths = x[rows], v[rows], before[rows], network.inverse_lengths[rows]
        limit_strain(xs, lengths, tolerance)
        touched = collide_body(xs, vs, x0, field0, field1, frame, times, scheme, friction, thickness)
        for _ in range(_SWEEPS if touched else 0):
            limit_strain(xs, lengths, tolerance)
            collide_body(xs, vs, x0, field0, field1, frame, times, scheme, friction, thickness)
