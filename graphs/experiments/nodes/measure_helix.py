"""Sag and stiffness of a curl against rod theory."""

from typing import Annotated

from hairpipe.graphs.experiments.studies.accuracy.sample import Sample

from hairpipe.data import Table
from hairpipe.graph import node
from hairpipe.groom.helix import Helix
from hairpipe.units import Ge, Gt, Interval, MetresPerSecondSquared

Segments = tuple[Annotated[int, Interval(ge=2, le=400)], ...]
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
    """Sag of a hanging curl and its stiffness as a spring, against those of a curly Kirchhoff rod: the worst of all.

    sample        what the strand is made of
    curl          its shape at rest; wound either way
    segments      of each strand
    gravities     ascending
    orientations  of curl and gravity together in the world
    """
    from hairpipe.graphs.experiments.studies.accuracy.helix import helix_table

    return helix_table(sample, curl, segments, gravities, orientations)
