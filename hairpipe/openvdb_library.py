"""OpenVDB's Python module, where there is one, in a process of its own.

It is a package `openvdb` (a studio's, conda), the copy in Blender's wheel, which is loaded without Blender, or Debian's
`pyopenvdb`. The module trusts the counts in a file, so that a damaged one can end its process, and prints at its end.
"""

import importlib.metadata
import io
import re
import subprocess
import sys
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from signal import Signals
from types import ModuleType
from typing import Any, Literal

import numpy as np

from hairpipe.child import command, environment
from hairpipe.errors import BadInput

BOOT = "from hairpipe.child import die_with_parent; die_with_parent();from hairpipe.openvdb_library import main; main()"
MOST_VOXELS = 1 << 26
"""Maximum number of active voxels of a grid that is read."""
Arrays = dict[str, np.ndarray]


def find_openvdb() -> Path | None:
    """Return the file of the module; None where there is none that works with this numpy."""
    wheel = find_spec("bpy")
    folders = (wheel and wheel.submodule_search_locations) or []
    copies = [path for folder in folders for path in Path(folder).glob("*/python/lib/*/*/openvdb*.so")]
    own = find_spec("openvdb")
    if own and own.origin:
        return Path(own.origin)
    old = find_spec("pyopenvdb") if np.lib.NumpyVersion(np.__version__) < "2.0.0" else None  # it crashes with 2
    return copies[0] if copies else Path(old.origin) if old and old.origin else None


def version_of_openvdb() -> str | None:
    """Return release and source of the module, or why it cannot be used; None where there is none."""
    place = find_openvdb()
    if place is None:
        return None
    try:
        release = ".".join(map(str, ask("version", "openvdb")["version"].tolist()))
    except BadInput as fault:
        return f"unusable: {fault}"
    return f"{release} of bpy {importlib.metadata.version('bpy')}" if "bpy" in place.parts else release


def ask(task: Literal["version", "read", "levelset"], where: object, **given: Any) -> Arrays:
    """Return the result of a task, see the functions of these names, which are given arrays or texts.

    Raises BadInput, with the place `where`, where there is no module, or where it refuses or its process ends.
    """
    if find_openvdb() is None:
        right = "Python with openvdb, or pip install 'hairpipe[cycles]' with Python 3.11 or 3.13, which has a copy"
        raise BadInput("OpenVDB's Python module is not installed", where=where, right=right)
    packed = io.BytesIO()
    np.savez(packed, task=task, **given)
    child = subprocess.run(command(BOOT), input=packed.getvalue(), capture_output=True, env=environment())
    if child.returncode < 0:
        raise BadInput(f"OpenVDB was ended by {Signals(-child.returncode).name}", where=where, right="a sound file")
    if child.returncode or not child.stdout:
        *_, what = ["no message", *re.findall(r"^\w*Error: (.+)$", child.stderr.decode(errors="replace"), re.MULTILINE)]
        raise BadInput(f"OpenVDB failed: {what[:200]}", where=where)
    with np.load(io.BytesIO(child.stdout)) as found:
        return dict(found)


def main() -> None:
    """Carry out the task on standard input; write arrays to standard output."""
    with np.load(io.BytesIO(sys.stdin.buffer.read())) as packed:
        given = {name: values if values.ndim else values.item() for name, values in packed.items()}
    task = {"version": version, "read": read, "levelset": levelset}[given.pop("task")]
    found = io.BytesIO()
    np.savez(found, **task(imported(), **given))
    sys.stdout.buffer.write(found.getvalue())


def imported() -> ModuleType:
    """Import the module from its file."""
    place = find_openvdb()
    spec = place and spec_from_file_location("pyopenvdb" if "pyopenvdb" in place.name else "openvdb", place)
    if not spec or not spec.loader:
        raise BadInput("OpenVDB's Python module is not installed")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def version(vdb: ModuleType) -> Arrays:
    """Return the release of the library, (3,) int."""
    return {"version": np.array(vdb.LIBRARY_VERSION)}


def read(vdb: ModuleType, path: str, name: str) -> Arrays:
    """Return the active voxels of a grid of numbers: indices (n, 3), values (n,), and matrix (4, 4) for row vectors.

    Tiles of value 0 are left out.
    Error where it is another grid, or has too many voxels.
    """
    grid = vdb.read(path, name)
    if grid.valueTypeName.startswith("pt") or not isinstance(grid.background, int | float):
        raise TypeError(f"the grid is one of {grid.valueTypeName}, not of numbers")
    if grid.activeVoxelCount() > MOST_VOXELS:
        raise ValueError(f"the grid has more than {MOST_VOXELS:,} voxels")
    kind = np.dtype([("low", "3i4"), ("high", "3i4"), ("value", "f4")])
    tiles = np.fromiter(((item.min, item.max, item.value) for item in grid.citerOnValues()), kind)
    is_voxel = (tiles["low"] == tiles["high"]).all(axis=1)
    indices = [tiles["low"][is_voxel].astype(np.int64)]
    values = [tiles["value"][is_voxel]]
    for low, high, value in tiles[~is_voxel & (tiles["value"] != 0.0)]:
        sides = (high - low + 1).tolist()
        indices.append(np.stack(np.unravel_index(np.arange(np.prod(sides)), sides), axis=1) + low)
        values.append(np.full(len(indices[-1]), value, np.float32))
    corners = np.array([grid.transform.indexToWorld(corner) for corner in (*np.eye(3).tolist(), (0.0, 0.0, 0.0))])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[3, :3] = corners[:3] - corners[3], corners[3]
    return {"indices": np.concatenate(indices), "values": np.concatenate(values), "matrix": matrix}


def levelset(
    vdb: ModuleType, corners: np.ndarray, voxel: float, half_width: float, first: np.ndarray, samples: np.ndarray
) -> Arrays:
    """Return the distance from a closed surface on a lattice [m], float32, at most `half_width` voxels in amount.

    corners  of its triangles [m], (m, 3, 3)
    first    index of the first sample, (3,), and samples: their number along each axis, (3,)
    """
    points, triangles = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    grid = vdb.FloatGrid.createLevelSetFromPolygons(
        points.astype(np.float32),
        triangles=triangles.reshape(-1, 3).astype(np.uint32),
        transform=vdb.createLinearTransform(voxelSize=voxel),
        halfWidth=half_width,
    )
    distance = np.empty(samples.tolist(), np.float32)
    grid.copyToArray(distance, ijk=tuple(first.tolist()))
    return {"distance": distance}
