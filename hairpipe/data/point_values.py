"""What is measured at every point of hair."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class PointValues:
    """Values at the points of strands, to look at; a name carries its unit, as in "depth [mm]".

    names    K of them
    values   one row a name, (K, p) float32
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,) int32
    """

    names: tuple[str, ...]
    values: np.ndarray
    offsets: np.ndarray
