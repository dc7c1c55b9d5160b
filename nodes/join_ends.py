"""The ends of several grooms as those of one."""

from hairpipe.data import Ends
from hairpipe.graph import node


@node(frames="each")
def join_ends(ends: tuple[Ends, ...]) -> Ends:
    """The ends of all strands in turn: of grooms that `join_grooms` joins in the same order."""
    from hairpipe.groom.joining import joined_ends

    return joined_ends(ends)
