"""All pictures as one that moves."""

from typing import Annotated

from hairpipe.graph import File, Frames, Time, Workspace, node
from hairpipe.units import Interval


@node(frames="once")
def flipbook(
    pictures: Frames[File],
    time: Time,
    workspace: Workspace,
    *,
    scale: Annotated[float, Interval(gt=0.0, le=1.0)] = 1.0,
    quality: Annotated[int, Interval(ge=0, le=100)] = 85,
) -> File:
    """Animated WebP of all frames, at the speed of the shot, over and over; browsers open it.

    scale    of the animation over the pictures
    quality  of the compression: higher is larger
    """
    from hairpipe.io.picture import write_webp

    path, numbers = workspace / "film.webp", pictures.numbers
    write_webp(path, len(numbers), lambda n: pictures[numbers[n]].path, fps=time.fps, scale=scale, quality=quality)
    return File(path)
