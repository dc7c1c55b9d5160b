"""Sag and stiffness of a curl compared with rod theory."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.geometry.curl import Helix
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Segments
from hairpipe.units import Ge, Gt, MetresPerSecondSquared
from hairpipe.values import Table

Gravities = tuple[Annotated[MetresPerSecondSquared, Gt(0.0)], ...]


@node(frames="once")
def measure_helix(
    *,
    sample: Sample = Sample(),  # noqa: B008 (frozen)
    curl: Helix = Helix(radius=0.008, pitch=0.012),  # noqa: B008
    segments: Segments = (25, 50, 100),
    gravities: Gravities = (0.1, 0.3, 1.0, 3.0, 9.81),
    orientations: Annotated[int, Ge(1)] = 3,
) -> Table:
    """Measure sag and spring stiffness of a hanging curl against a curled Kirchhoff rod, and take the maximum error.

    sample        model, material and length of the strand
    curl          rest shape of the curl, wound in both directions
    segments      numbers of segments of each strand
    gravities     gravitational accelerations, ascending
    orientations  number of rotations of curl and gravity together
    """
    from hairpipe.graphs.experiments.studies.accuracy.helix import helix_table

    return helix_table(sample, curl, segments, gravities, orientations)
