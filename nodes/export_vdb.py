"""Level set and density of hair as an OpenVDB file."""

from typing import Annotated

from hairpipe.engine import File, Time, Workspace, node
from hairpipe.units import Suffixes
from hairpipe.values import Density, LevelSet


@node(frames="each")
def export_vdb(
    surface: LevelSet | None, density: Density | None, time: Time, workspace: Workspace, *, half: bool = False
) -> Annotated[File, Suffixes((".vdb",))]:
    """Write level set `surface`, its velocity `vel`, fog `density` and its velocity `hair_vel` to OpenVDB, in metres.

    half  storage in 16 bits: nearly half the size, with a relative error of at most 1 / 2000
    """
    from hairpipe.errors import BadInput
    from hairpipe.formats.vdb import density_grids, surface_grids, write

    grids = [*(surface_grids(surface) if surface else []), *(density_grids(density) if density else [])]
    if not grids:
        raise BadInput("nothing is connected", where="in", right="in.surface, in.density or both")
    path = workspace / ("surface.vdb" if surface else "density.vdb")
    write(path, grids, time.frame, half)
    return File(path)
