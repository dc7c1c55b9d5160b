"""The shot as USD."""

from typing import Literal

from hairpipe.data import Groom, Mesh, Strands
from hairpipe.graph import File, Frames, Time, Workspace, node


@node(frames="once")
def export_usd(
    hair: Frames[Strands],
    body: Frames[Mesh] | None,
    groom: Groom | None,
    time: Time,
    workspace: Workspace,
    *,
    layout: Literal["single", "clips"] = "single",
    name: str = "shot",
) -> File:
    """USD of the hair as Catmull-Rom curves and of the body as a mesh, with velocities, at every frame.

    layout  one file, or one file a frame that the first one joins as value clips
    name    of the root prim, and of the folder of clips: give two shots in one place two names
    """
    from hairpipe.io.usd.shot import Shot, write_clips, write_shot

    path, shot = workspace / f"{name}.usdc", Shot(hair, body, groom, time.fps, name)
    if layout == "clips":
        return File(path, write_clips(path, shot))
    write_shot(path, shot)
    return File(path)
