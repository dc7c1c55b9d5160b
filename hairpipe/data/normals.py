"""Directions in which hair faces."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Normals:
    """Normals of hair as one body at the points of its strands, to shade it with.

    vectors  unit; 0 where there is none, (p, 3) float32
    """

    vectors: np.ndarray
