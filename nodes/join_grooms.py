"""Several grooms as one."""

from hairpipe.data import Groom
from hairpipe.graph import node


@node(frames="once")
def join_grooms(grooms: tuple[Groom, ...], *, groups: tuple[str, ...] = ()) -> Groom:
    """Concatenate the strands of grooms, and renumber them.

    groups  name of the group that each groom becomes, in their order; by default grooms keep their groups
    """
    from hairpipe.groom.joining import joined_strands

    return joined_strands(grooms, groups)
