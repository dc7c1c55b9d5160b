"""Errors of level sets interpolated between keys."""

from typing import Annotated

from hairpipe.engine import Frames, Time, node
from hairpipe.units import Ge
from hairpipe.values import Body, BodyParts, LevelSet, Mesh, Table


@node(frames="once")
def measure_between(
    rest: Body,
    body: Frames[Mesh],
    surface: Frames[LevelSet],
    parts: Frames[BodyParts],
    time: Time,
    *,
    stride: Annotated[int, Ge(1)] = 4,
) -> Table:
    """Measure errors of level sets interpolated between keys, against the skin at the frames in between.

    stride  number of frames from one key to the next: at 96 frames a second, a stride of 4 gives 24 keys a second
    """
    from hairpipe.graphs.experiments.studies.interpolation.clips import Clip, clip_table

    return clip_table(rest.mesh, Clip(body, surface, parts), stride, time.dt)
