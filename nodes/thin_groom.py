"""A groom with fewer strands."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Interval
from hairpipe.values import Groom


@node(frames="once")
def thin_groom(groom: Groom, *, every: Annotated[int, Interval(ge=1, le=1_000_000)] = 4) -> Groom:
    """Keep every n-th strand, with its id.

    every  number of strands of which one is kept
    """
    from hairpipe.errors import BadInput
    from hairpipe.groom.sampling import thinned

    if every // 2 >= len(groom.ids):
        raise BadInput(f"every = {every} removes all {len(groom.ids)} strands", right="less")
    return thinned(groom, every)
