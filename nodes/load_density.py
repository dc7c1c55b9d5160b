"""Density of hair from a file."""

from pathlib import Path
from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Gt, Metres, Suffixes
from hairpipe.values import Density


@node(frames="once")
def load_density(
    *, file: Annotated[Path, Suffixes((".vdb",))], grid: str = "density", unit: Annotated[Metres, Gt(0.0)] = 1.0
) -> Density:
    """Read a fog volume from OpenVDB as a target density, unchanged and without velocities.

    file  path of the OpenVDB file. Compression by Blosc needs `pip install 'hairpipe[vdb]'`; kinds of files and grids
          that we do not read are read by OpenVDB's Python module, where it is installed
    grid  name of the grid in the file: numbers, not points or vectors
    unit  metres per unit of the file
    """
    from hairpipe.formats.vdb import read_voxels
    from hairpipe.volume.density import density_of_voxels

    found = read_voxels(file, grid)
    return density_of_voxels(found.indices, found.values, unit * found.voxel, unit * found.translation)
