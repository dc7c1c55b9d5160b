"""A body from a file."""

from pathlib import Path
from typing import Annotated, Literal

from hairpipe.body.scalp import Scalp
from hairpipe.engine import node
from hairpipe.formats.registry import list_parts, suffixes_of
from hairpipe.plain_file import Absent
from hairpipe.units import Interval, Metres, Reads, Suffixes
from hairpipe.values import Body


@node(frames="once")
def load_body(
    *,
    file: Annotated[Path, Suffixes(suffixes_of("body")), Reads(list_parts)],
    group: str | None = None,
    skeleton: Path | None = None,
    weights: Path | None = None,
    unit: Annotated[Metres, Interval(ge=1e-6, le=1e6)] = 1.0,
    up: Literal["y", "z"] = "y",
    time_code: float | None = None,
    absent: Absent = "refuse",
    joint: str = "head",
    scalp: Scalp | None = None,
) -> Body:
    """Read mesh, skeleton, weights and painted maps from OBJ, PLY, USD, glTF or Alembic; in metres, Y up, facing +Z.

    Triangles that face inward, as a mirrored or carelessly exported mesh has them, are turned outward, with a warning.

    file       path of the mesh; a USD or glTF file contains the skeleton, too
    group      name of a group or object of an OBJ file, path or pattern (*/head*) of prims of a USD file, or name of a
               node of a glTF file, to read alone
    skeleton   path of a MakeHuman rig (.mhskel) for an OBJ file
    weights    path of MakeHuman weights (.mhw) for the skeleton
    unit       metres per unit of an OBJ, PLY or Alembic file; a correction factor for a USD file, which states its unit
    up         vertical axis of such a file, or of a USD file that states a wrong one; Z-up bodies face -Y
    time_code  time code of a USD file; by default the first with samples of all meshes and curves
    absent     treatment of absent files that a USD stage names: refuse, or warn and read the rest
    joint      name of the only joint of a body without a skeleton, for the mapping to a clip
    scalp      hairline that defines the map "scalp"; if absent, the map of the file
    """
    from hairpipe.body.preparation import prepare
    from hairpipe.formats.registry import read_body
    from hairpipe.levelset.outer_shell import turned_outward

    body = read_body(file, group=group, skeleton=skeleton, weights=weights, time=time_code, absent=absent)
    return turned_outward(prepare(body, unit=unit, up=up, joint=joint, scalp=scalp))
