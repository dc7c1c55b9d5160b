"""Naturally curved strands that hang, compared with rod theory."""

from typing import NamedTuple

from hairpipe.engine import node
from hairpipe.graphs.experiments.studies.accuracy.sample import Numbers, Sample, Segments
from hairpipe.values import Table


class Hanging(NamedTuple):
    """Onset of helices from hooks and from coils, and the height of a helix."""

    hooks: Table
    coils: Table
    heights: Table


@node(frames="once")
def measure_hanging(
    *,
    sample: Sample = Sample(model="rod"),  # noqa: B008 (frozen)
    segments: Segments = (25, 50, 100),
    weights: Numbers = (30.0, 100.0, 300.0),
    curvatures: Numbers = (8.0, 12.0),
    helix: tuple[float, float] = (20.0, 150.0),
) -> Hanging:
    """Measure where a hanging arc leaves its plane against the second variation of a rod, and its helix beyond.

    sample      model, material and length of the strand
    segments    numbers of segments of each strand
    weights     weights rho A g L^3 / (E I) of hooks, for which the natural curvature is searched
    curvatures  natural curvatures times length of coils, for which the weight is searched
    helix       curvature and weight of a helix whose height is compared with a boundary-value solution
    """
    from hairpipe.graphs.experiments.studies.accuracy.curls import coil_table, height_table, hook_table

    return Hanging(
        hook_table(sample, segments, weights),
        coil_table(sample, segments, curvatures),
        height_table(sample, segments, *helix),
    )
