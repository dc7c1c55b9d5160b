"""Level set and density of hair as an OpenVDB file."""

from typing import Annotated

from hairpipe.data import Density, LevelSet
from hairpipe.graph import File, Time, Workspace, node
from hairpipe.units import Suffixes


@node(frames="each")
def export_vdb(
    surface: LevelSet | None, density: Density | None, time: Time, workspace: Workspace, *, half: bool = False
) -> Annotated[File, Suffixes((".vdb",))]:
    """OpenVDB of a frame: level set `surface` and velocity `vel`, fog `density` and velocity `hair_vel`, in metres.

    half  keep 16 bits of every value: nearly half the size, and off by at most 1 in 2000
    """
    from hairpipe.errors import BadInput
    from hairpipe.levelset.vdb import write
    from hairpipe.levelset.vdb_grids import density_grids, surface_grids

    grids = [*(surface_grids(surface) if surface else []), *(density_grids(density) if density else [])]
    if not grids:
        raise BadInput("nothing is connected", where="in", right="in.surface, in.density or both")
    path = workspace / ("surface.vdb" if surface else "density.vdb")
    write(path, grids, time.frame, half)
    return File(path)
