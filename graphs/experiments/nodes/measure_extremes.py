"""Recovery of extreme strands."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Gt, Interval, Seconds
from hairpipe.values import Table

Rates = tuple[Annotated[int, Interval(ge=24, le=1_000_000)], ...]


@node(frames="once")
def measure_extremes(*, rates: Rates = (240, 24), seconds: Annotated[Seconds, Gt(0.0)] = 2.0) -> Table:
    """Measure stretch and speed of swinging strands that are stiff, soft, long, short, weightless or deformed.

    rates    numbers of steps per second
    seconds  duration of the run, for the strand to come to rest
    """
    from hairpipe.graphs.experiments.studies.integrators.extremes import extremes_table

    return extremes_table(rates, seconds)
