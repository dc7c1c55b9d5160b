"""Bending frequencies of a strand compared with rod theory."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Segments
from hairpipe.units import Interval
from hairpipe.values import Table


@node(frames="once")
def measure_vibration(
    *,
    sample: Sample = Sample(),  # noqa: B008 (frozen)
    segments: Segments = (25, 50, 100),
    modes: Annotated[int, Interval(ge=1, le=6)] = 3,
) -> Table:
    """Compute natural bending frequencies of a weightless straight strand clamped at its root, from its stiffness.

    sample    model, material and length of the strand
    segments  numbers of segments of each strand
    modes     number of modes, from the lowest
    """
    from hairpipe.graphs.experiments.studies.accuracy.vibration import vibration_table

    return vibration_table(sample, segments, modes)
