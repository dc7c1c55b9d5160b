"""A strand over a wire with weights at its ends, as hair is measured."""

from typing import NamedTuple

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Segments
from hairpipe.values import Table


class Balanced(NamedTuple):
    """Shape of the strand, and the modulus that its width gives."""

    shape: Table
    modulus: Table


@node(frames="once")
def measure_balanced(
    *,
    sample: Sample = Sample(),  # noqa: B008 (frozen)
    segments: Segments = (25, 50),
) -> Balanced:
    """Measure a weighted strand over a wire against the table of Scott and Robbins, and its bending modulus by theirs.

    sample    model, material and length of half of the strand
    segments  numbers of segments of half of the strand
    """
    from hairpipe.graphs.experiments.studies.accuracy.balanced import balanced_tables

    return Balanced(*balanced_tables(sample, segments))
