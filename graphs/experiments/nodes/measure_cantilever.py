"""Sag of a strand against rod theory."""

from typing import Annotated

from hairpipe.graphs.experiments.studies.accuracy.sample import Sample

from hairpipe.data import Table
from hairpipe.graph import node
from hairpipe.units import Degrees, Ge, Gt, Interval

Gammas = tuple[Annotated[float, Gt(0.0)], ...]
Segments = tuple[Annotated[int, Interval(ge=2, le=400)], ...]
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
    """Distance of the tip of a clamped strand under its weight from that of the elastica, the worst of all rolls.

    sample    what the strand is made of
    segments  of each strand
    angles    of the clamp from hanging straight down
    rolls     of the strand about its axis, equal steps of half a turn
    gammas    rho A g L^3 / (E I), ascending
    """
    from hairpipe.graphs.experiments.studies.accuracy.cantilever import cantilever_table

    return cantilever_table(sample, segments, angles, rolls, gammas)
