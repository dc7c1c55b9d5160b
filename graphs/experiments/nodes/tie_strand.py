"""A strand with a knot."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Gt, Interval, Metres
from hairpipe.values import Groom


@node(frames="once")
def tie_strand(
    *,
    length: Annotated[Metres, Gt(0.0)] = 0.6,
    segments: Annotated[int, Interval(ge=20, le=10_000)] = 100,
    radius: Annotated[Metres, Gt(0.0)] = 0.06,
    gap: Annotated[Metres, Gt(0.0)] = 4e-3,
    crossings: Annotated[int, Interval(ge=1, le=99)] = 3,
) -> Groom:
    """Build one strand along +X with a loose knot in its middle, the root at the origin.

    length     arc length of the strand from root to tip
    segments   number of equal segments
    radius     radius of the loop
    gap        distance of the axes of the two strands that wind around each other
    crossings  number of crossings of these, odd: 1 for a loop without a knot, 3 for an overhand knot
    """
    from hairpipe.graphs.experiments.studies.knots.shape import tied_strand

    return tied_strand(length, segments, radius, gap, crossings)
