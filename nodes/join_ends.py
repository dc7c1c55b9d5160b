"""Ends of several grooms as one list."""

from hairpipe.data import Ends
from hairpipe.graph import node


@node(frames="each")
def join_ends(ends: tuple[Ends, ...]) -> Ends:
    """Concatenate the ends of strands, in the order in which `join_grooms` joins their grooms."""
    from hairpipe.groom.joining import joined_ends

    return joined_ends(ends)
