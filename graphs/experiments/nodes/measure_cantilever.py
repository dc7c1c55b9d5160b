"""Sag of a strand compared with rod theory."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Segments
from hairpipe.units import Degrees, Ge, Gt, Interval
from hairpipe.values import Table

Gammas = tuple[Annotated[float, Gt(0.0)], ...]
Angles = tuple[Annotated[Degrees, Interval(ge=0.0, le=175.0)], ...]


@node(frames="once")
def measure_cantilever(
    *,
    sample: Sample = Sample(),  # noqa: B008 (frozen)
    segments: Segments = (10, 25, 50, 100),
    angles: Angles = (0.0, 45.0, 90.0, 135.0),
    rolls: Annotated[int, Ge(1)] = 4,
    gammas: Gammas = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0),
) -> Table:
    """Measure the distance of a cantilever's tip from that of the elastica, and take the maximum over all rolls.

    sample    model, material and length of the strand
    segments  numbers of segments of each strand
    angles    angles of the clamp from the vertical
    rolls     number of rolls about the axis of the strand, in equal steps over half a turn
    gammas    load parameters rho A g L^3 / (E I), ascending
    """
    from hairpipe.graphs.experiments.studies.accuracy.cantilever import cantilever_table

    return cantilever_table(sample, segments, angles, rolls, gammas)
