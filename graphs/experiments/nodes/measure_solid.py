"""A solid over time, as a table."""

from typing import Annotated

from hairpipe.engine import Frames, node
from hairpipe.graphs.experiments.elastic.elastic_values import ElasticState, Solid
from hairpipe.units import Ge
from hairpipe.values import Table


@node(frames="once")
def measure_solid(solid: Solid, states: Frames[ElasticState], *, every: Annotated[int, Ge(1)] = 1) -> Table:
    """Measure relative volume, flat and inverted tetrahedra, the smallest volume, the height of the top, and energy.

    every  number of frames from one row to the next
    """
    from hairpipe.graphs.experiments.measure.elastic_measures import measure_volume

    return measure_volume(solid, (states[frame] for frame in states.numbers[::every]))
