"""A strand in several orientations."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Ge, Interval, Metres
from hairpipe.values import Groom


@node(frames="once")
def fan_strands(
    groom: Groom,
    *,
    strands: Annotated[int, Interval(ge=1, le=1000)] = 9,
    radius: Annotated[Metres, Ge(0.0)] = 0.01,
) -> Groom:
    """Copy the first strand of a groom, rotated about the vertical in equal angles, with its root frame.

    strands  number of copies, one for each orientation
    radius   radius of the circle of roots
    """
    from hairpipe.graphs.experiments.studies.accuracy.fan import fanned

    return fanned(groom, strands, radius)
