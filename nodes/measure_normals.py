"""Normals that hair carries, as numbers."""

from hairpipe.data import LevelSet, Normals, Strands, Table
from hairpipe.graph import Frames, node


@node(frames="once")
def measure_normals(hair: Frames[Strands], normals: Frames[Normals], shell: Frames[LevelSet]) -> Table:
    """How far normals that hair carries, and its light, are from those of its shell at every frame: a row a frame."""
    from hairpipe.measure.volume.shell import shell_table

    return shell_table(hair, normals, shell)
