"""Hair that has come to rest."""

from typing import Annotated

from hairpipe.engine import Frames, Time, node
from hairpipe.units import Gt, Seconds
from hairpipe.values import Strands, Table


@node(frames="once")
def measure_rest(
    hair: Frames[Strands], truth: Strands | None, time: Time, *, seconds: Annotated[Seconds, Gt(0.0)] = 1.0
) -> Table:
    """Measure drift, reported and actual speed of hair in the last seconds, and its distance from a truth: one row.

    seconds  duration of the measurement, up to the last frame
    """
    from hairpipe.graphs.experiments.measure.rest import rest_table

    return rest_table(hair, truth, time.fps, seconds)
