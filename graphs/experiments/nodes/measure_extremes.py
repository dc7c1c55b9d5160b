"""The oddest strands, and whether they come back."""

from typing import Annotated

from hairpipe.data import Table
from hairpipe.graph import node
from hairpipe.units import Gt, Interval, Seconds

Rates = tuple[Annotated[int, Interval(ge=24, le=1_000_000)], ...]


@node(frames="once")
def measure_extremes(*, rates: Rates = (240, 24), seconds: Annotated[Seconds, Gt(0.0)] = 2.0) -> Table:
    """Stretch and speed of a swinging strand that is stiff, soft, long, short, weightless, scattered or crushed.

    rates    steps a second
    seconds  that it is given to come to rest
    """
    from hairpipe.graphs.experiments.studies.integrators.extremes import extremes_table

    return extremes_table(rates, seconds)
