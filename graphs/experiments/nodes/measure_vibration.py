"""Bending frequencies of a strand against rod theory."""

from typing import Annotated

from hairpipe.graphs.experiments.studies.accuracy.sample import Sample

from hairpipe.data import Table
from hairpipe.graph import node
from hairpipe.units import Interval

Segments = tuple[Annotated[int, Interval(ge=2, le=400)], ...]


@node(frames="once")
def measure_vibration(
    *,
    sample: Sample = Sample(),  # noqa: B008 (frozen)
    segments: Segments = (25, 50, 100),
    modes: Annotated[int, Interval(ge=1, le=6)] = 3,
) -> Table:
    """Natural bending frequencies of a straight strand clamped at its root, without weight, from its stiffness.

    sample    what the strand is made of
    segments  of each strand
    modes     so many, from the lowest
    """
    from hairpipe.graphs.experiments.studies.accuracy.vibration import vibration_table

    return vibration_table(sample, segments, modes)
