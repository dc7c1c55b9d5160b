"""Pictures of all frames as an animation."""

from typing import Annotated

from hairpipe.engine import File, Frames, Time, Workspace, node
from hairpipe.units import Interval, Suffixes


@node(frames="once")
def flipbook(
    pictures: Frames[File],
    time: Time,
    workspace: Workspace,
    *,
    scale: Annotated[float, Interval(gt=0.0, le=1.0)] = 1.0,
    quality: Annotated[int, Interval(ge=0, le=100)] = 85,
) -> Annotated[File, Suffixes((".webp",))]:
    """Write all frames as an animated WebP that repeats at the speed of the shot.

    If the run leaves out frames, the previous frame is shown for longer.

    scale    size ratio of the animation to the pictures
    quality  quality of the compression; higher values give larger files
    """
    from hairpipe.formats.pictures import write_webp

    path = workspace / "film.webp"
    write_webp(path, pictures.numbers, lambda n: pictures[n].path, fps=time.fps, scale=scale, quality=quality)
    return File(path)
