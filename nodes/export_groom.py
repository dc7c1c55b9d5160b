"""Hair and guides for another program."""

from typing import Annotated, Literal

from hairpipe.engine import File, Frames, Time, Workspace, node
from hairpipe.units import Degrees, Interval, Suffixes
from hairpipe.values import Body, Groom, Strands


@node(frames="once")
def export_groom(
    groom: Groom,
    hair: Frames[Strands] | None,
    keys: Groom | None,
    key_hair: Frames[Strands] | None,
    scalp: Body | None,
    time: Time,
    workspace: Workspace,
    *,
    target: Literal["unreal", "houdini", "blender"] = "unreal",
    parting: Annotated[Degrees, Interval(gt=0.0, le=180.0)] = 30.0,
    hairs: Annotated[int, Interval(ge=1)] | None = None,
) -> Annotated[File, Suffixes((".usd", ".usdc"))]:
    """Write a groom for Unreal, Houdini or Blender: hair and guides in one USD file, in the types that each reads.

    With `hair` the file is a cache: points and velocities at every frame. With `keys` these strands are guides, next to
    the hair, and each hair has the ids and weights of its three guides; their motion is that of the same strands of
    `hair`, or else `key_hair`. `hairpipe usd check --for TARGET` checks such files.

    target   format of the primvars: unreal (centimetres, Z up, GroomAPI), houdini (rest shape) or blender
    parting  maximum angle between a strand and its guides at rest, from root to tip
    hairs    number of hairs that the strands represent, as in `export_usd`; if absent, widths are diameters
    """
    from hairpipe.formats.usd.shot import GroomShot, write_groom
    from hairpipe.groom.guides import with_guides

    path = workspace / "groom.usdc"
    whole, frames, closest = with_guides(groom, hair, keys, key_hair, parting)
    write_groom(path, GroomShot(whole, frames, closest, scalp, time.fps, hairs), target)
    return File(path)
