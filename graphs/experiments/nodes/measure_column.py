"""Buckling of an upright strand under its weight compared with rod theory."""

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Segments
from hairpipe.values import Table


@node(frames="once")
def measure_column(
    *,
    sample: Sample = Sample(),  # noqa: B008 (frozen)
    segments: Segments = (25, 50, 100),
) -> Table:
    """Find the weight at which an upright strand buckles: one stiffness falls to zero.

    sample    model, material and length of the strand
    segments  numbers of segments of each strand
    """
    from hairpipe.graphs.experiments.studies.accuracy.column import column_table

    return column_table(sample, segments)
