"""Values at every point of hair: what is measured there, and the directions in which hair faces."""

import numpy as np

from hairpipe.data.value import value


@value
class PointValues:
    """Values at the points of strands, to look at; a name carries its unit, as in "depth [mm]".

    names    K of them
    values   one row a name, (K, p) float32
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,) int32
    """

    names: tuple[str, ...]
    values: np.ndarray
    offsets: np.ndarray


@value
class Normals:
    """Normals of hair as one body at the points of its strands, to shade it with.

    vectors  unit; 0 where there is none, (p, 3) float32
    """

    vectors: np.ndarray
