"""Values at points."""

import numpy as np

from hairpipe.engine import node
from hairpipe.values import PointValues, Strands


@node(frames="each")
def sense(hair: Strands) -> PointValues:
    """How high hair is."""
    return PointValues(("height [mm]",), 1e3 * hair.points[None, :, 1].astype(np.float32), hair.offsets)
