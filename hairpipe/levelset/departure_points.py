"""What an interpolation between two frames decides: where to read each, and how to weigh them."""

from typing import NamedTuple


class Places(NamedTuple):
    """Two points and a weight: the value there is (1 - weight) * that of the first frame + weight * that of the second.

    weight      of the second frame, 0 to 1
    x0, y0, z0  where to read the first frame [m]
    x1, y1, z1  where to read the second frame [m]
    """

    weight: float
    x0: float
    y0: float
    z0: float
    x1: float
    y1: float
    z1: float
