"""Hair shown that is not simulated."""

from hairpipe.data import Ends, Groom, Mesh, Strands
from hairpipe.graph import node


@node(frames="each")
def follow_guides(hair: Strands, guides: Groom, groom: Groom, body: Mesh | None, ends: Ends | None) -> Strands:
    """All strands of a groom, each moving as the simulated one with the nearest root, to see what is lost by that.

    The ends are those of the whole groom.
    """
    from hairpipe.errors import BadInput
    from hairpipe.groom.guiding import guided
    from hairpipe.sim.roots import motion_of_roots

    if len(hair.points) != len(guides.points):
        raise BadInput("hair and guides are not the same strands", right="in.guides: the groom that is simulated")
    return guided(hair, guides, groom, *motion_of_roots(body or ends, groom))
