"""Groomed hair on a moving body, without a simulation."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Interval, Metres
from hairpipe.values import Ends, Groom, Mesh, Strands


@node(frames="each")
def carry_groom(
    groom: Groom, body: Mesh | None, ends: Ends | None, *, diameter: Annotated[Metres, Interval(gt=0.0, le=1e-2)] = 8e-5
) -> Strands:
    """Move the strands of a groom rigidly with the body.

    diameter  diameter of each strand
    """
    from hairpipe.groom.binding import rigid_strands
    from hairpipe.solve.boundary import driver_of, motion_of_roots

    return rigid_strands(groom, *motion_of_roots(driver_of(body, ends), groom), diameter)
