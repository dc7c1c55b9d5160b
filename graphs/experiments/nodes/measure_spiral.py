"""A hanging spiral compared with rod theory."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Segments, Spiral
from hairpipe.units import Ge, Gt, MetresPerSecondSquared
from hairpipe.values import Table

Gravities = tuple[Annotated[MetresPerSecondSquared, Gt(0.0)], ...]


@node(frames="once")
def measure_spiral(
    *,
    sample: Sample = Sample(),  # noqa: B008 (frozen)
    spiral: Spiral = Spiral(),  # noqa: B008
    segments: Segments = (25, 50, 100),
    gravities: Gravities = (0.1, 0.3, 1.0, 3.0, 9.81),
    orientations: Annotated[int, Ge(1)] = 2,
) -> Table:
    """Measure how far the tip of a hanging spiral with torsion moves under its weight against a Kirchhoff rod.

    sample        model, material and length of the strand
    spiral        rest shape, wound in both directions
    segments      numbers of segments of each strand
    gravities     gravitational accelerations, ascending
    orientations  number of rotations of spiral and gravity together
    """
    from hairpipe.graphs.experiments.studies.accuracy.spiral import spiral_table

    return spiral_table(sample, spiral, segments, gravities, orientations)
