"""Density of roots on the body: where hair grows, skin between the strands drawn takes the colour of hair."""

import numpy as np
from numba import njit

from hairpipe.render.shadows import CELLS, add, look_up_all

REACH = 0.012
"""Edge of the cells that roots are counted in: the softness of the hairline [m]."""


def hair_share(points: np.ndarray, roots: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Say how densely roots stand on the skin, 1 where as densely as usual, 0 where there are none, (n,) float64.

    points  of the skin [m], (n, 3) float64
    roots   [m], (S, 3) float64
    axes    of the cells, rows of a rotation, (3, 3)
    """
    shift = CELLS / 2 - axes @ roots.mean(axis=0) / REACH
    to_cells = np.column_stack([axes / REACH, shift])
    counts = np.zeros((CELLS, CELLS, CELLS), np.float32)
    count(counts, roots @ to_cells[:, :3].T + shift)
    usual = np.median(look_up_all(counts, to_cells, roots))
    return np.clip(look_up_all(counts, to_cells, points) / max(usual, 1e-6), 0.0, 1.0)


@njit(cache=True, nogil=True)
def count(counts: np.ndarray, places: np.ndarray) -> None:
    """Count the places (n, 3) in the cells, in place."""
    for p in range(len(places)):
        add(counts, places[p, 0], places[p, 1], places[p, 2], 1.0)
