"""All pictures as one that moves."""

from typing import Annotated

from hairpipe.graph import File, Frames, Time, Workspace, node
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
    """Animated WebP of all frames, at the speed of the shot, over and over; browsers open it.

    Frames that the run leaves out are made up for: the one before them is shown for longer.

    scale    of the animation over the pictures
    quality  of the compression: higher is larger
    """
    from hairpipe.io.picture import write_webp

    path = workspace / "film.webp"
    write_webp(path, pictures.numbers, lambda n: pictures[n].path, fps=time.fps, scale=scale, quality=quality)
    return File(path)
