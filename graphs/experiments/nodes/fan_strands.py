"""A strand in several orientations."""

from typing import Annotated

from hairpipe.data import Groom
from hairpipe.graph import node
from hairpipe.units import Ge, Interval, Metres


@node(frames="once")
def fan_strands(
    groom: Groom,
    *,
    strands: Annotated[int, Interval(ge=1, le=1000)] = 9,
    radius: Annotated[Metres, Ge(0.0)] = 0.01,
) -> Groom:
    """The first strand of a groom in equal parts of a turn about the vertical, roots and their frames with it.

    strands  in so many orientations
    radius   of the circle of roots
    """
    from hairpipe.graphs.experiments.studies.accuracy.fan import fanned

    return fanned(groom, strands, radius)
