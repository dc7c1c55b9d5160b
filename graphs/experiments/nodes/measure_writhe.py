"""Buckling twist of a strand compared with rod theory."""

from typing import NamedTuple

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Segments
from hairpipe.values import Table


class Writhe(NamedTuple):
    """Smallest stiffness over twist, and the twist of buckling."""

    way: Table
    onset: Table


@node(frames="once")
def measure_writhe(
    *,
    sample: Sample = Sample(),  # noqa: B008 (frozen)
    segments: Segments = (25, 50, 100),
) -> Writhe:
    """Find the twist at which a straight strand between clamps buckles: one stiffness falls to zero.

    sample    model, material and length of the strand
    segments  numbers of segments of each strand
    """
    from hairpipe.graphs.experiments.studies.accuracy.writhe import writhe_tables

    return Writhe(*writhe_tables(sample, segments))
