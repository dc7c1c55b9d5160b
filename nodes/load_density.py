"""Density of hair from a file."""

from pathlib import Path
from typing import Annotated

from hairpipe.data import Density
from hairpipe.graph import node
from hairpipe.units import Gt, Metres, Suffixes


@node(frames="once")
def load_density(
    *, file: Annotated[Path, Suffixes((".vdb",))], grid: str = "density", unit: Annotated[Metres, Gt(0.0)] = 1.0
) -> Density:
    """A fog of an OpenVDB file, such as hair is led to; with its numbers as they are, and without velocities.

    file  OpenVDB, uncompressed or zip
    grid  its name there
    unit  metres in one unit of the file
    """
    from hairpipe.levelset.vdb_read import read_voxels
    from hairpipe.volume.density import density_of_voxels

    found = read_voxels(file, grid)
    return density_of_voxels(found.indices, found.values, unit * found.voxel, unit * found.translation)
