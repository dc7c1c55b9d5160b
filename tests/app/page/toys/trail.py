"""A simulation of hair."""

from dataclasses import replace

from hairpipe.engine import node
from hairpipe.values import Strands


@node(frames="scan")
def trail(hair: Strands, previous: Strands | None, *, share: float = 0.5) -> Strands:
    """Hair that lags behind.

    share  of the way to where it should be that it goes in a frame
    """
    if previous is None:
        return hair
    return replace(hair, points=previous.points + share * (hair.points - previous.points))
