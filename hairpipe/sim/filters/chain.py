"""The filters of a step, one after the other, block by block: a block that nothing touches is passed once."""

import numpy as np
from numba import njit, prange

from hairpipe.levelset.field import Field
from hairpipe.sim.filters.collide_body import collide_body
from hairpipe.sim.filters.limit_strain import limit_strain
from hairpipe.sim.models.interface import shape_of

_SWEEPS = 2  # contact stretches what it pushes, and drawing that in may push it back: twice leaves a few percent


@njit(cache=True, parallel=True)
def limit_all(model, x, tolerance):  # noqa: ANN001, ANN201
    """Limit the strain of hair that has nothing to collide with, in place; see `limit_strain`.

    x  positions [m], (rows, 3, W)
    """
    for block in prange(len(model.first) - 1):
        rows = slice(model.first[block], model.first[block + 1])
        limit_strain(x[rows], model.inverse_lengths[rows], shape_of(model), tolerance)


@njit(cache=True, parallel=True)
def limit_and_collide(  # noqa: ANN201
    model,  # noqa: ANN001
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
):
    """Limit strain and move hair out of the body, in place; see `limit_strain` and `collide_body`.

    x, v, before  (rows, 3, W)
    tolerance     inf: strain is not limited
    """
    for block in prange(len(model.first) - 1):
        rows = slice(model.first[block], model.first[block + 1])
        xs, vs, x0, lengths, shape = x[rows], v[rows], before[rows], model.inverse_lengths[rows], shape_of(model)
        limited = tolerance < np.inf
        if limited:
            limit_strain(xs, lengths, shape, tolerance)
        touched = collide_body(xs, vs, x0, shape, field0, field1, frame, times, scheme, friction, thickness)
        for _ in range(_SWEEPS if touched and limited else 0):
            limit_strain(xs, lengths, shape, tolerance)
            collide_body(xs, vs, x0, shape, field0, field1, frame, times, scheme, friction, thickness)
