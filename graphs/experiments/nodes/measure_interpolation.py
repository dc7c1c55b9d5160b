"""Interpolation between frames compared with analytic bodies."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Fraction, Interval, Metres, MinLen, Voxels
from hairpipe.values import Table


@node(frames="once")
def measure_interpolation(
    *,
    fractions: Annotated[tuple[Fraction, ...], MinLen(1)] = (0.5,),
    voxel: Annotated[Metres, Interval(ge=0.01, le=0.2)] = 0.05,
    half_width: Annotated[Voxels, Interval(ge=2.0, le=64.0)] = 8.0,
) -> Table:
    """Measure errors of level sets between frames, for ellipsoids and capsules that move, turn, bend and approach.

    The method "two-sided" is as published, except that a velocity known at one frame only keeps its full value: at a
    motion of one radius per frame its error is 0.26 % of the radius, that of the published formula 4.1 %.

    fractions   times after the first frame, in frames
    voxel       sample spacing of the grid; the bodies are about 0.6 m large
    half_width  half width of the narrow band
    """
    from hairpipe.graphs.experiments.studies.interpolation.surface_errors import interpolation_table

    return interpolation_table(fractions, voxel, half_width)
