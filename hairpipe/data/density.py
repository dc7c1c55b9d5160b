"""How much hair there is, and how it moves."""

import numpy as np

from hairpipe.data.value import value


@value
class Density:
    """Hair on a box of nodes; node (i, j, k) lies at cell * (low + (i, j, k)). Beyond the box there is none.

    low       of the first node, in cells from the world's origin, (3,) int32
    cell      distance of the nodes [m]
    length    of hair per volume [m/m^3], (nx, ny, nz) float32
    velocity  of hair there, the mean by length; 0 where there is none [m/s], (nx, ny, nz, 3) float32
    """

    low: np.ndarray
    cell: float
    length: np.ndarray
    velocity: np.ndarray
