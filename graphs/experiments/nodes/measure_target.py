"""Distance of hair from a target density."""

from hairpipe.engine import Frames, flat_group, node
from hairpipe.laws.settings import Target
from hairpipe.values import Density, Strands, Table


@node(frames="once")
@flat_group("settings")
def measure_target(hair: Frames[Strands], target: Frames[Density], *, settings: Target) -> Table:
    """Measure the energy of the difference of two densities, relative to the first frame and to empty space.

    The latter is 0 for equal densities, and about 2 for densities without overlap.
    """
    from hairpipe.graphs.experiments.measure.target import target_table

    return target_table(hair, target, settings.cell, settings.levels)
