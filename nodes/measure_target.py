"""How near hair is to the density that it is led to."""

from hairpipe.data import Density, Strands, Table
from hairpipe.graph import Frames, flat_group, node
from hairpipe.sim.settings import Target


@node(frames="once")
@flat_group("settings")
def measure_target(hair: Frames[Strands], target: Frames[Density], *, settings: Target) -> Table:
    """Energy of the difference of two densities at every frame, over that of the first, and over that without hair.

    The second is 0 where hair has the density of the target, and about 2 where it is all elsewhere.
    """
    from hairpipe.measure.volume.target import target_table

    return target_table(hair, target, settings.cell, settings.levels)
