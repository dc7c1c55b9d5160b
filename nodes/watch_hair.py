"""How fast hair moves and how far it is stretched, frame by frame while it is simulated."""

from hairpipe.data import Groom, Strands, Table
from hairpipe.graph import node


@node(frames="each")
def watch_hair(hair: Strands, groom: Groom) -> Table:
    """One row for all strands: speeds, the longest stretch over their length in the groom, and mean height.

    A wedge gives a variant up as soon as such a frame fails one of its criteria.
    """
    from hairpipe.measure.motion import watch

    return watch(hair, groom)
