"""Several grooms as one."""

from hairpipe.data import Groom
from hairpipe.graph import node


@node(frames="once")
def join_grooms(grooms: tuple[Groom, ...]) -> Groom:
    """Concatenate the strands of grooms, and renumber them."""
    from hairpipe.groom.joining import joined_strands

    return joined_strands(grooms)
