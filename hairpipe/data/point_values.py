"""Values at every point of hair: what is measured there, and the directions in which hair faces."""

import numpy as np

from hairpipe.data.value import value


@value
class PointValues:
    """Values at the points of strands, for display; a name contains its unit, as in "depth [mm]".

    names    names of the K values
    values   one row per name, (K, p) float32
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,) int32
    """

    names: tuple[str, ...]
    values: np.ndarray
    offsets: np.ndarray


@value
class Normals:
    """Normals of the hair volume at the points of its strands, for shading.

    vectors  unit normals; 0 where undefined, (p, 3) float32
    """

    vectors: np.ndarray
