"""A shell over time, as a table."""

from typing import Annotated

from hairpipe.engine import Frames, node
from hairpipe.graphs.experiments.elastic.elastic_values import ElasticState, Shell
from hairpipe.units import Ge
from hairpipe.values import Table


@node(frames="once")
def measure_shell(shell: Shell, states: Frames[ElasticState], *, every: Annotated[int, Ge(1)] = 1) -> Table:
    """Measure the error of angles between triangles against those at rest, the centre of the points, and the energy.

    every  number of frames from one row to the next
    """
    from hairpipe.graphs.experiments.measure.elastic_measures import measure_angles

    return measure_angles(shell, (states[frame] for frame in states.numbers[::every]))
