"""Bodies and grooms from USD files (usd, usda, usdc, usdz), in metres with Y up."""

from pathlib import Path

from hairpipe.apart import work_apart
from hairpipe.data import Body
from hairpipe.data.curves import Curves
from hairpipe.io.usd.groom import curves
from hairpipe.io.usd.meshes import skinned_meshes
from hairpipe.plain_file import Absent


def read_body(path: Path, prim: str | None = None, time: float | None = None, absent: Absent = "refuse") -> Body:
    """Read the meshes of a stage as one body at rest, with the UsdSkel skeletons that move them.

    Polygons are triangulated. Float primvars on vertices become maps, `st` texture coordinates; invisible meshes and
    those of purpose proxy or guide are omitted. Bound meshes are in the rest pose of their skeleton, others in their
    pose at one time; without any skeleton the body has no joints.

    prim    path of a mesh or of a parent of meshes; by default the whole stage
    time    time code; by default the first at which all meshes and curves have samples, and a warning if the body moves
    absent  whether absent files of the stage are refused, or warned of

    Raises BadInput if the file, or what it says, cannot be used; the message names the prim.
    """
    return work_apart(skinned_meshes.read, path, prim, time, absent)


def read_curves(
    path: Path,
    prim: str | None = None,
    time: float | None = None,
    guides: bool = False,
    absent: Absent = "refuse",
) -> Curves:
    """Read all BasisCurves and cubic NurbsCurves of a stage at one time as strands, root first.

    Invisible curves and those of purpose proxy are omitted; those of purpose guide, too, where there are others.
    Linear and Catmull-Rom curves interpolate their points, which are returned unchanged; B-splines, Bezier curves and
    NURBS are evaluated. Those without pins are returned with the ends of pinned ones, as spare points. The
    rest shape is that of primvar `pref` or `rest`, ids are those of `hairId`, `groom_id` or `id`.

    prim    path of curves or of a parent of curves; by default the whole stage
    time    as of `read_body`
    guides  whether curves of purpose guide are read in any case
    absent  as of `read_body`

    Raises BadInput if the file, or what it says, cannot be used; the message names the prim and the curve.
    """
    return work_apart(curves.read, path, prim, time, guides, absent)
