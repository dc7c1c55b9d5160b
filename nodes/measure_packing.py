"""How hair lies among hair, as numbers."""

from typing import Annotated

from hairpipe.data import Strands, Table
from hairpipe.graph import Frames, node
from hairpipe.units import Ge, Gt, Metres


@node(frames="once")
def measure_packing(
    hair: Frames[Strands],
    reference: Frames[Strands],
    *,
    cell: Annotated[Metres, Gt(0.0)] = 0.006,
    near: Annotated[Metres, Gt(0.0)] = 0.004,
    skip: Annotated[int, Ge(0)] = 1,
) -> Table:
    """Speed of neighbours, distance of strands, room, density and its histogram, and error: one row of means.

    The reference is the same hair simulated otherwise.

    cell  side of the cubes in which hair is counted
    near  distance up to which points of two strands are neighbours
    skip  frames at the beginning that do not count
    """
    from hairpipe.measure.volume.packing import packing_table

    return packing_table(hair, reference, cell, near, skip)
