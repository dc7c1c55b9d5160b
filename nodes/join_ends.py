"""Ends of several grooms as one list."""

from hairpipe.engine import node
from hairpipe.values import Ends


@node(frames="each")
def join_ends(ends: tuple[Ends, ...]) -> Ends:
    """Concatenate the ends of strands, in the order in which `join_grooms` joins their grooms."""
    from hairpipe.groom.sampling import joined_ends

    return joined_ends(ends)
