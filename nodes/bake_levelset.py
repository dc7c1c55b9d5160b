"""Level set of the body."""

from typing import Annotated, Literal

from hairpipe.engine import node
from hairpipe.units import Calls, Gt, Interval, Metres, Voxels
from hairpipe.values import LevelSet, Mesh


@node(frames="each")
def bake_levelset(
    body: Mesh | None = None,
    sheets: Mesh | None = None,
    *,
    voxel: Annotated[Metres, Interval(ge=2e-4, le=0.1)] = 0.005,
    half_width: Annotated[Voxels, Interval(ge=2.0, le=64.0)] = 8.0,
    holes: Literal["fill", "refuse"] = "fill",
    thickness: Annotated[Metres, Gt(0)] | None = None,
    engine: Annotated[Literal["hairpipe", "openvdb"], Calls("openvdb", ("openvdb", "bpy", "pyopenvdb"))] = "hairpipe",
) -> LevelSet:
    """Compute signed distance and velocity of the body, in a narrow band around its surface.

    The body is solid. Sheets are open surfaces, such as garments, that stop hair on either side, alone or with the body
    as one collider; closed pieces of these are solid, too.

    voxel       sample spacing of the grid; thinner parts of a body do not stop hair
    half_width  half width of the narrow band; hair outside it has no contact
    holes       treatment of an open body: fill its holes, or refuse it with a message
    thickness   thickness of sheets, at least two voxels; by default two voxels
    engine      method of distances and signs in the band: ours, or for comparison that of OpenVDB, which is less
                accurate and needs its Python module
    """
    from hairpipe.errors import BadInput
    from hairpipe.levelset.bake import bake, bake_by_openvdb, bake_sheets

    if sheets is not None:
        if engine == "openvdb":
            raise BadInput("OpenVDB converts solid bodies alone", where="engine", right='"hairpipe" for sheets')
        return bake_sheets(body, sheets, voxel, half_width, holes, thickness)
    if body is None or thickness is not None:
        right = "in.body for what is solid, in.sheets for open surfaces"
        raise BadInput(f"there are no {'sheets' if body else 'surfaces'}", where="bake_levelset", right=right)
    return (bake_by_openvdb if engine == "openvdb" else bake)(body, voxel, half_width, holes)
