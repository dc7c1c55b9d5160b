"""Shapes of naturally curved strands that hang, over curvature and weight."""

from typing import Annotated, NamedTuple

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.accuracy.sample import Numbers, Sample
from hairpipe.units import Interval
from hairpipe.values import Table


class CurlMap(NamedTuple):
    """Shapes of strands, the border of planar shapes by rod theory, and the pitch along a helix."""

    shapes: Table
    border: Table
    pitches: Table


@node(frames="once")
def map_curls(
    *,
    sample: Sample = Sample(model="rod"),  # noqa: B008 (frozen)
    segments: Annotated[int, Interval(ge=10, le=400)] = 60,
    curvatures: Numbers = (2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0),
    weights: Numbers = (5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0),
    hooks: Numbers = (20.0, 30.0, 60.0, 150.0, 400.0, 1000.0, 2000.0),
    coils: Numbers = (6.0, 7.0, 8.0, 10.0, 12.0, 14.0),
    helix: tuple[float, float] = (60.0, 1500.0),
    helix_segments: Annotated[int, Interval(ge=10, le=400)] = 100,
) -> CurlMap:
    """Settle hanging arcs over natural curvature and weight, and compare the pitch of a helix with its local tension.

    sample           model, material and length of the strand
    segments         number of segments of a strand
    curvatures       natural curvatures of strands, times length
    weights          weights of strands, rho A g L^3 / (E I)
    hooks            weights at which the border of hooks is solved
    coils            curvatures at which the border of coils is solved
    helix            curvature and weight of the helix
    helix_segments   number of segments of the helix
    """
    from hairpipe.graphs.experiments.studies.accuracy.curls import border_table, pitch_table, shape_table

    return CurlMap(
        shape_table(sample, segments, curvatures, weights),
        border_table(sample, hooks, coils),
        pitch_table(sample, [helix_segments], *helix),
    )
