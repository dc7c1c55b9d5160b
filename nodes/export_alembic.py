"""Hair and guides in Alembic, for another program."""

from typing import Annotated, Literal

from hairpipe.engine import File, Frames, Time, Workspace, node
from hairpipe.units import Degrees, Interval, Suffixes
from hairpipe.values import Groom, Strands


@node(frames="once")
def export_alembic(
    groom: Groom,
    hair: Frames[Strands] | None,
    keys: Groom | None,
    key_hair: Frames[Strands] | None,
    time: Time,
    workspace: Workspace,
    *,
    target: Literal["unreal", "houdini", "blender"] = "unreal",
    parting: Annotated[Degrees, Interval(gt=0.0, le=180.0)] = 30.0,
    hairs: Annotated[int, Interval(ge=1)] | None = None,
) -> Annotated[File, Suffixes((".abc",))]:
    """Write a groom for Unreal, Houdini or Blender in Alembic, with the attributes of Unreal's groom specification.

    With `hair` the file is a cache: points and velocities at the true times of frames. With `keys` these strands are
    guides, as in `export_groom`, which writes the same in USD. Needs `pip install 'hairpipe[alembic]'`.

    target   format of the attributes: unreal (centimetres and its axes: rotation 0, scale 1 at import), houdini
             (rest shape) or blender
    parting  maximum angle between a strand and its guides at rest, from root to tip
    hairs    number of hairs that the strands represent, as in `export_usd`; if absent, widths are diameters
    """
    from hairpipe.formats.alembic import write_alembic
    from hairpipe.formats.groom_shot import GroomShot
    from hairpipe.groom.guides import with_guides

    path = workspace / "groom.abc"
    whole, frames, closest = with_guides(groom, hair, keys, key_hair, parting)
    write_alembic(path, GroomShot(whole, frames, closest, None, time.fps, hairs), target)
    return File(path)
