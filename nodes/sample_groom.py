"""Representative strands of a groom."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Ge, Interval
from hairpipe.values import Groom


@node(frames="once")
def sample_groom(
    groom: Groom,
    *,
    strands: Annotated[int, Interval(ge=1, le=1_000_000)] = 96,
    patches: Annotated[int, Interval(ge=1, le=10_000)] = 4,
    number: Annotated[int, Ge(0)] = 0,
) -> Groom:
    """Select patches of neighbouring strands, evenly over the groom; a small groom is unchanged.

    strands  total number of strands, rounded up to a multiple of the patches
    patches  number of patches of equal size
    number   number of the sample; different samples have no strand in common
    """
    from hairpipe.groom.sampling import sample_patches

    return sample_patches(groom, strands, patches, number)
