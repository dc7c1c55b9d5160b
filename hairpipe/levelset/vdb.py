"""OpenVDB files: the one place that loads OpenVDB's Python module, and what is written with it."""

import hashlib
import importlib.util
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from hairpipe.data import LevelSet
from hairpipe.errors import BadInput
from hairpipe.levelset.grid_layout import BRICK
from hairpipe.levelset.vdb_header import UUID, Grid, inspect

__all__ = ["Grid", "inspect", "module", "write"]


@cache
def module() -> ModuleType:
    """Return OpenVDB's Python module: the installed one, the copy in Blender's wheel, or Debian's.

    They are imported by statements, for keys to see. Raises BadInput where there is none that works with this numpy.
    """
    if importlib.util.find_spec("openvdb"):
        import openvdb  # pyright: ignore[reportMissingImports]

        return openvdb
    blender = library_in_blender()
    if blender:
        return loaded("openvdb", blender)
    if not importlib.util.find_spec("pyopenvdb"):
        raise BadInput("OpenVDB's Python module is not installed", right="pip install 'hairpipe[vdb]'")
    if int(np.__version__.split(".")[0]) >= 2:
        raise BadInput("pyopenvdb crashes with numpy 2", right="pip install 'hairpipe[vdb]', or numpy < 2")
    import pyopenvdb  # pyright: ignore[reportMissingImports]

    return pyopenvdb


def library_in_blender() -> Path | None:
    """Return OpenVDB's library within the bpy wheel, which is found but not imported: that would start Blender."""
    wheel = importlib.util.find_spec("bpy")
    folders = wheel.submodule_search_locations if wheel else None
    pattern = "*/python/lib/python3.*/site-packages/openvdb*.so"
    return min((path for folder in folders or [] for path in Path(folder).glob(pattern)), default=None)


def loaded(name: str, library: Path) -> ModuleType:
    """Return the extension module that lies at a path no import would look at."""
    spec = importlib.util.spec_from_file_location(name, library)
    assert spec and spec.loader
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def write(path: Path, surface: LevelSet, frame: int, half: bool = False) -> None:
    """Write the grids `surface` (level set) and `vel` (vectors, where the band is) as an OpenVDB file.

    frame  number of the frame, kept as metadata
    half   keep 16 bits of every value: nearly half the size, and off by at most 1 in 2000

    Values are those of the bricks, bit for bit unless halved; the same values give the same bytes. Raises BadInput
    where OpenVDB is missing.
    """
    facts = {"creator": "hairpipe", "file_units": "metres", "frame": frame}
    grids = [surface_grid(surface), velocity_grid(surface)]
    for grid in grids:
        grid.transform = module().createLinearTransform(voxelSize=surface.voxel)
        grid.saveFloatAsHalf = half
        for name, value in (facts | {"voxel": surface.voxel, "half_width": surface.half_width}).items():
            grid[name] = value
    module().write(str(path), grids=grids, metadata=facts)
    name_by_content(path)


def surface_grid(surface: LevelSet) -> Any:
    """Return the distance as OpenVDB's level set."""
    background = np.float32(surface.voxel * surface.half_width)
    grid = module().FloatGrid(float(background))
    grid.name = "surface"
    grid.gridClass = module().GridClass.LEVEL_SET
    fill(grid, surface, np.where(surface.distance > -background, surface.distance, background))
    # What is beyond the band is left at the background's value, without its sign; this spreads the sign from the band.
    grid.signedFloodFill()
    return grid


def velocity_grid(surface: LevelSet) -> Any:
    """Return the velocity in the band as OpenVDB's vectors; 0 beyond it."""
    grid = module().Vec3SGrid((0.0, 0.0, 0.0))
    grid.name = "vel"
    grid.vectorType = module().VectorType.CONTRAVARIANT_RELATIVE
    banded = np.abs(surface.distance) < np.float32(surface.voxel * surface.half_width)
    fill(grid, surface, np.where(banded[..., None], surface.velocity, np.float32(0)))
    return grid


def fill(grid: Any, surface: LevelSet, values: np.ndarray) -> None:
    """Copy the bricks into a grid, in place; values equal to its background stay inactive.

    values  of the bricks' samples, (B, 9, 9, 9) or (B, 9, 9, 9, 3) float32
    """
    first = np.rint(surface.origin / surface.voxel).astype(int)
    for place in np.argwhere(surface.bricks >= 0):
        block = values[surface.bricks[tuple(place)], :BRICK, :BRICK, :BRICK]
        grid.copyFromArray(np.ascontiguousarray(block), ijk=tuple((first + BRICK * place).tolist()))


def name_by_content(path: Path) -> None:
    """Replace the random identifier that OpenVDB writes into a file by one made from the rest of its bytes."""
    data = bytearray(path.read_bytes())
    data[UUID] = bytes(36)
    digest = hashlib.sha256(data).hexdigest()
    data[UUID] = "-".join([digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32]]).encode()
    path.write_bytes(data)
