"""The level set as an OpenVDB file."""

from hairpipe.data import LevelSet
from hairpipe.graph import File, Time, Workspace, node


@node(frames="each")
def export_vdb(surface: LevelSet, time: Time, workspace: Workspace, *, half: bool = False) -> File:
    """OpenVDB of a frame: the level set `surface` and the velocity `vel`, in metres.

    half  keep 16 bits of every value: nearly half the size, and off by at most 1 in 2000
    """
    from hairpipe.levelset.vdb import write

    path = workspace / "surface.vdb"
    write(path, surface, time.frame, half)
    return File(path)
