"""An animated mesh of any origin."""

from pathlib import Path
from typing import Annotated, Literal

from hairpipe.engine import Cuts, First, Time, node
from hairpipe.formats.registry import list_files, suffixes_of
from hairpipe.plain_file import Absent
from hairpipe.units import Gt, Interval, Metres, Reads, Suffixes
from hairpipe.values import Body, Mesh


@node(frames="each")
def load_mesh_cache(
    time: Time,
    cuts: Cuts,
    rest: Body | None = None,
    first: First = First(1001),  # noqa: B008 - a number
    *,
    file: Annotated[Path, Suffixes(suffixes_of("meshes")), Reads(list_files)],
    group: str | None = None,
    clip: str | None = None,
    unit: Annotated[Metres, Interval(ge=1e-6, le=1e6)] = 1.0,
    up: Literal["y", "z"] = "y",
    at: int | None = None,
    start: float | None = None,
    speed: Annotated[float, Gt(0)] = 1.0,
    velocities: Literal["file", "samples"] = "file",
    absent: Absent = "refuse",
) -> Mesh:
    """Read an animated mesh with the velocity of every vertex, from USD, Alembic, glTF or a sequence of files.

    Meshes of USD may have time samples, value clips, moving parents, UsdSkel skeletons and blend shapes, which are
    evaluated as OpenUSD bakes them; those of glTF skins and morph targets. Sub-frame samples are used: points follow a
    cubic through the samples. Polygons must be the same at all times. With a body at rest, the mesh is that body in
    motion; without one it is a collider. One sample, such as an OBJ file without a number, holds still.

    file        path of the file, or of a sequence of OBJ or PLY files: mesh.####.obj
    group       path of the prim or object to read, with all below, or a pattern such as */garment*; for OBJ a group
    clip        name of an animation of a glTF file, or a pattern of names (*) to join some; by default the first take
    unit        metres per unit of an Alembic, OBJ or PLY file; a correction factor for USD, which states its unit
    up          vertical axis of an Alembic, OBJ or PLY file
    at          frame of the shot that shows the time code `start`, by default 1001
    start       time code of a USD file, number of a file of a sequence, or time of Alembic and glTF in frames of the
                shot; by default the first sample. Without `at` and `start` a file that reaches the frames of the shot
                keeps its times; another one begins at 1001, or at the first frame of a later shot, with a warning
    speed       playback speed: 0.5 is half the recorded speed
    velocities  velocity of the vertices: file (that of the file, if there is one) or samples (slope of the points)
    absent      treatment of absent files that a USD stage names: refuse, or warn and read the rest
    """
    from hairpipe.body.preparation import follow
    from hairpipe.formats.animated_meshes import AT, Instant
    from hairpipe.formats.registry import read_moving

    def elapsed(frame: int) -> float:
        return (frame - (AT if at is None else at)) / time.fps * speed

    sides = tuple((elapsed(cut - 1), elapsed(cut)) for cut in cuts)
    reference = None if rest is None else rest.time
    place = (AT, first) if at is None else (at, None)
    instant = Instant(start, elapsed(time.frame), sides, *place, velocities, reference, time.fps, speed)
    mesh, owners = read_moving(file, group, clip, instant, absent)
    return follow(rest, mesh, owners, unit=unit, up=up)
