"""Twist at which a strand writhes against rod theory."""

from typing import Annotated, NamedTuple

from hairpipe.graphs.experiments.studies.accuracy.sample import Sample

from hairpipe.data import Table
from hairpipe.graph import node
from hairpipe.units import Interval

Segments = tuple[Annotated[int, Interval(ge=2, le=400)], ...]


class Writhe(NamedTuple):
    """Smallest stiffness as the strand is twisted, and where that ends."""

    way: Table
    onset: Table


@node(frames="once")
def measure_writhe(
    *,
    sample: Sample = Sample(),  # noqa: B008 (frozen)
    segments: Segments = (25, 50, 100),
) -> Writhe:
    """Twist between clamps, one of them sliding, at which a straight strand buckles: its stiffness falls to zero.

    sample    what the strand is made of
    segments  of each strand
    """
    from hairpipe.graphs.experiments.studies.accuracy.writhe import writhe_tables

    return Writhe(*writhe_tables(sample, segments))
