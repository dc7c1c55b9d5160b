"""Writing of a value to a file of any supported format, by its suffix."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hairpipe.errors import BadInput
from hairpipe.values import Body, Groom, Mesh, Strands, Table

SUFFIXES = (".h5", ".hdf5", ".npz", ".csv", ".usd", ".usda", ".usdc")


def write_value(path: Path, value: Any, frame: int, fps: float) -> None:
    """Write a value, whole or not at all; CSV and USD of a body hold its mesh at rest.

    frame  frame of the value, and frames per second, for formats with time

    Raises BadInput for an unknown suffix, or one that does not support the value, OSError for a path without access.
    """
    write = writer(path, value, frame, fps)
    path.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(dir=path.parent, prefix=".hairpipe-") as folder:
        temporary = Path(folder, f"value{path.suffix.lower()}")
        write(temporary)
        temporary.replace(path)


def writer(path: Path, value: Any, frame: int, fps: float) -> Callable[[Path], None]:
    """Choose the writer of a value; imports only this one."""
    suffix = path.suffix.lower()
    if suffix in (".h5", ".hdf5"):
        from hairpipe.formats.hdf5 import encode

        return lambda to: encode(value, to)
    if suffix == ".npz":
        from hairpipe.formats.tables import write_npz

        return lambda to: write_npz(to, value)
    if suffix not in SUFFIXES:
        raise BadInput(f"values are not written as {suffix or 'such'} files", where=path, right=", ".join(SUFFIXES))
    if isinstance(value, Table) and suffix == ".csv":
        from hairpipe.formats.tables import write_csv

        return lambda to: write_csv(to, value)
    shape = value.mesh if isinstance(value, Body) else value
    if not isinstance(shape, Mesh | Strands | Groom):
        raise BadInput(f"a {type(value).__name__} has no points to write", where=path, right=".h5 or .npz")
    if suffix == ".csv":
        from hairpipe.formats.tables import write_points

        velocities, offsets = (getattr(shape, name, None) for name in ("velocities", "offsets"))
        return lambda to: write_points(to, shape.points, velocities, offsets)
    from hairpipe.formats.usd.shot import write_still

    return lambda to: write_still(to, shape, frame, fps)
