"""Torque of a twisted strand compared with rod theory."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Segments
from hairpipe.units import Gt
from hairpipe.values import Table

Twists = tuple[Annotated[float, Gt(0.0)], ...]


@node(frames="once")
def measure_torsion(
    *,
    sample: Sample = Sample(),  # noqa: B008 (frozen)
    segments: Segments = (25, 50, 100),
    twists: Twists = (0.1, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
) -> Table:
    """Measure the torque of a twisted straight strand against theory, in both directions, and the drift of a free tip.

    sample    model, material and length of the strand
    segments  numbers of segments of each strand
    twists    twist angles of the far end [rad], ascending; the end slides along the axis
    """
    from hairpipe.graphs.experiments.studies.accuracy.torsion import torsion_table

    return torsion_table(sample, segments, twists)
