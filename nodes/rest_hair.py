"""Hair before anything has moved it."""

from typing import Annotated

from hairpipe.data import Groom, Strands
from hairpipe.graph import node
from hairpipe.units import Interval, Metres


@node(frames="once")
def rest_hair(groom: Groom, *, diameter: Annotated[Metres, Interval(ge=1e-5, le=2e-3)] = 80e-6) -> Strands:
    """A groom as hair at rest, to draw or to measure.

    diameter  of the fibre
    """
    import numpy as np

    return Strands(groom.points, np.zeros(groom.points.shape, np.float32), groom.offsets, diameter)
