"""The space around the parts of a body."""

from typing import Annotated

from hairpipe.data import Body, BodyParts, Pose
from hairpipe.graph import node
from hairpipe.units import Interval, Metres, Voxels


@node(frames="each")
def bake_parts(
    rest: Body,
    pose: Pose | None = None,
    *,
    voxel: Annotated[Metres, Interval(ge=2e-4, le=0.1)] = 0.005,
    half_width: Annotated[Voxels, Interval(ge=2.0, le=64.0)] = 8.0,
    smallest: Annotated[Metres, Interval(ge=0.0, le=10.0)] = 0.18,
) -> BodyParts:
    """Signed distance of the body, one level set for each group of bones, which moves with them between frames.

    voxel       spacing of the samples; what is thinner than that stops no hair
    half_width  of the band; hair farther than that does not feel the body
    smallest    skin that a bone needs for a part of its own, measured across; others move with their parents
    """
    from hairpipe.levelset.bake.parts import bake_parts as bake

    return bake(rest, pose, voxel, half_width, smallest)
