"""Errors of rotated normals."""

from hairpipe.engine import Frames, node
from hairpipe.values import LevelSet, Normals, Strands, Table


@node(frames="once")
def measure_normals(hair: Frames[Strands], normals: Frames[Normals], shell: Frames[LevelSet]) -> Table:
    """Measure errors of rotated normals, and of their shading, against those of the shell at every frame."""
    from hairpipe.graphs.experiments.measure.shell_normals import shell_table

    return shell_table(hair, normals, shell)
