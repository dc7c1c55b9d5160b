"""A shell over time, as a table."""

from typing import Annotated

from hairpipe.data import ElasticState, Shell, Table
from hairpipe.graph import Frames, node
from hairpipe.units import Ge


@node(frames="once")
def measure_shell(shell: Shell, states: Frames[ElasticState], *, every: Annotated[int, Ge(1)] = 1) -> Table:
    """Error of the angles between triangles against those at rest, where the middle of the points is, and energy.

    every  so many frames there is a row
    """
    from hairpipe.graphs.experiments.elastic.elastic_measures import measure_angles

    return measure_angles(shell, (states[frame] for frame in states.numbers[::every]))
