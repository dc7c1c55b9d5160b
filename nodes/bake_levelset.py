"""Level set of the body."""

from typing import Annotated, Literal

from hairpipe.data import LevelSet, Mesh
from hairpipe.graph import node
from hairpipe.units import Interval, Metres, Voxels


@node(frames="each")
def bake_levelset(
    body: Mesh,
    *,
    voxel: Annotated[Metres, Interval(ge=2e-4, le=0.1)] = 0.005,
    half_width: Annotated[Voxels, Interval(ge=2.0, le=64.0)] = 8.0,
    holes: Literal["fill", "refuse"] = "fill",
) -> LevelSet:
    """Compute signed distance and velocity of the body, in a narrow band around its surface.

    voxel       sample spacing of the grid; thinner parts do not stop hair
    half_width  half width of the narrow band; hair outside it has no contact
    holes       treatment of an open mesh: fill its holes, or refuse it with a message
    """
    from hairpipe.levelset.bake.whole import bake

    return bake(body, voxel, half_width, holes)
