"""Buckling twist of a ring compared with rod theory."""

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Segments
from hairpipe.values import Table


@node(frames="once")
def measure_ring(
    *,
    sample: Sample = Sample(),  # noqa: B008 (frozen)
    segments: Segments = (25, 50, 100),
) -> Table:
    """Find the twist at which a straight strand that is closed to a ring leaves its plane: one stiffness falls to zero.

    sample    model, material and length of the strand
    segments  numbers of segments of each strand
    """
    from hairpipe.graphs.experiments.studies.accuracy.ring import ring_table

    return ring_table(sample, segments)
