"""Level sets of the parts of a body."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Interval, Metres, Voxels
from hairpipe.values import Body, BodyParts, Pose


@node(frames="each")
def bake_parts(
    rest: Body,
    pose: Pose | None = None,
    *,
    voxel: Annotated[Metres, Interval(ge=2e-4, le=0.1)] = 0.005,
    half_width: Annotated[Voxels, Interval(ge=2.0, le=64.0)] = 8.0,
    smallest: Annotated[Metres, Interval(ge=0.0, le=10.0)] = 0.18,
) -> BodyParts:
    """Compute signed distances of the body, with one level set for each group of bones, which it follows rigidly.

    voxel       sample spacing of the grid; thinner parts do not stop hair
    half_width  half width of the narrow band; hair outside it has no contact
    smallest    minimum extent of the skin of a bone with its own part; smaller ones belong to the part of their parent
    """
    from hairpipe.levelset.bake_parts import bake_parts as bake

    return bake(rest, pose, voxel, half_width, smallest)
