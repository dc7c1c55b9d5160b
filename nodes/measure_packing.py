"""Arrangement of strands among each other, in numbers."""

from typing import Annotated

from hairpipe.engine import Frames, node
from hairpipe.units import Ge, Gt, Metres
from hairpipe.values import Strands, Table


@node(frames="once")
def measure_packing(
    hair: Frames[Strands],
    reference: Frames[Strands],
    *,
    cell: Annotated[Metres, Gt(0.0)] = 0.006,
    near: Annotated[Metres, Gt(0.0)] = 0.004,
    skip: Annotated[int, Ge(0)] = 1,
) -> Table:
    """Measure speed of neighbours, strand distance, volume, density with its histogram, and error: one row of means.

    The reference is another simulation of the same hair.

    cell  edge length of the cubes for counting hair
    near  maximum distance of points of two neighbouring strands
    skip  number of frames to exclude at the beginning
    """
    from hairpipe.measure.contact import packing_table

    return packing_table(hair, reference, cell, near, skip)
