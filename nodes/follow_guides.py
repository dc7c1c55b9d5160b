"""Hair shown that is not simulated."""

from hairpipe.data import Ends, Groom, Mesh, Strands
from hairpipe.graph import node


@node(frames="each")
def follow_guides(hair: Strands, guides: Groom, groom: Groom, body: Mesh | None, ends: Ends | None) -> Strands:
    """All strands of a groom, each moving as the simulated one with the nearest root, to see what is lost by that.

    The ends are those of the whole groom.
    """
    import numpy as np

    from hairpipe.errors import BadInput
    from hairpipe.groom.guiding import guided
    from hairpipe.sim.boundary import lead_of, motion_of_roots

    if not np.array_equal(hair.offsets, guides.offsets):
        raise BadInput("hair and guides are not the same strands", right="in.guides: the groom that is simulated")
    return guided(hair, guides, groom, *motion_of_roots(lead_of(body, ends), groom))
