"""A few strands that stand for all."""

from typing import Annotated

from hairpipe.data import Groom
from hairpipe.graph import node
from hairpipe.units import Ge, Interval


@node(frames="once")
def sample_groom(
    groom: Groom,
    *,
    strands: Annotated[int, Interval(ge=1, le=1_000_000)] = 96,
    patches: Annotated[int, Interval(ge=1, le=10_000)] = 4,
    number: Annotated[int, Ge(0)] = 0,
) -> Groom:
    """Patches of neighbouring strands, spread evenly over the groom; a groom of no more strands is given as it is.

    strands  altogether, rounded up to a multiple of the patches
    patches  of equal size
    number   of the sample: samples of different numbers share no strand
    """
    from hairpipe.groom.sampling import sample_patches

    return sample_patches(groom, strands, patches, number)
