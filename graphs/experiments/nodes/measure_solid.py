"""A solid over time, as a table."""

from typing import Annotated

from hairpipe.data import ElasticState, Solid, Table
from hairpipe.graph import Frames, node
from hairpipe.units import Ge


@node(frames="once")
def measure_solid(solid: Solid, states: Frames[ElasticState], *, every: Annotated[int, Ge(1)] = 1) -> Table:
    """Volume over that at rest, tetrahedra flat or inverted, the least volume of one, height of the top, and energy.

    every  so many frames there is a row
    """
    from hairpipe.graphs.experiments.elastic.elastic_measures import measure_volume

    return measure_volume(solid, (states[frame] for frame in states.numbers[::every]))
