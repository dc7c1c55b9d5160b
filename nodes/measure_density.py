"""Density of hair on a grid."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Interval, Metres
from hairpipe.values import Density, Strands


@node(frames="each")
def measure_density(hair: Strands, *, cell: Annotated[Metres, Interval(ge=5e-4, le=0.2)] = 0.006) -> Density:
    """Compute length of hair per volume and its mean velocity, on the grid of `[hair.volume]`.

    cell  spacing of the grid nodes
    """
    from hairpipe.volume.density import density_of

    return density_of(hair, cell)
