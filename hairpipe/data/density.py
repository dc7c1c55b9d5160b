"""Density of hair, and its velocity."""

import numpy as np

from hairpipe.data.value import value


@value
class Density:
    """Density of hair on a box of nodes, 0 outside; node (i, j, k) lies at cell * (low + (i, j, k)).

    low       index of the first node, in cells from the world's origin, (3,) int32
    cell      spacing of the nodes [m]
    length    length of hair per volume [m/m^3], (nx, ny, nz) float32
    velocity  mean velocity of hair, weighted by length; 0 without hair [m/s], (nx, ny, nz, 3) float32
    """

    low: np.ndarray
    cell: float
    length: np.ndarray
    velocity: np.ndarray
