"""The space around the body."""

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
    """Signed distance and velocity of the body, in a narrow band around its surface.

    voxel       spacing of the samples; parts thinner than that stop no hair
    half_width  of the band; hair farther than that does not feel the body
    holes       of an open mesh: cap them, or stop with a message
    """
    from hairpipe.levelset.bake.whole import bake

    return bake(body, voxel, half_width, holes)
