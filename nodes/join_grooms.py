"""Several grooms as one."""

from hairpipe.engine import node
from hairpipe.values import Groom


@node(frames="once")
def join_grooms(grooms: tuple[Groom, ...], *, groups: tuple[str, ...] = ()) -> Groom:
    """Concatenate the strands of grooms, and renumber them.

    groups  name of the group that each groom becomes, in their order; by default grooms keep their groups
    """
    from hairpipe.groom.sampling import joined_strands

    return joined_strands(grooms, groups)
