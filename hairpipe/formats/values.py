"""Values as files, by the suffix: HDF5, NPZ, USD, points as CSV, and tables as CSV and Markdown."""

import csv
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from zipfile import ZipFile, ZipInfo

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.hdf5 import Tree, encode, take_apart
from hairpipe.values import Body, Groom, Mesh, Strands, Table
from hairpipe.values.table import joined


def lay_below(tables: Sequence[Table], cases: Sequence[str]) -> Table:
    """Join tables below each other, see `joined`; BadInput where they do not match."""
    try:
        return joined(tables, cases)
    except ValueError as error:
        raise BadInput(str(error), right="tables with the same columns, and a name for each or none") from None


def write_csv(path: Path, table: Table) -> None:
    """Write the names and the rows, with numbers in full precision."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(table.names)
        writer.writerows(table.rows())


def write_markdown(path: Path, table: Table) -> None:
    """Write a table of Markdown, numbers with four digits and to the right."""
    marks = ["---" if name in table.texts else "---:" for name in table.names]
    rows = [table.names, marks, *([formatted(value) for value in row] for row in table.rows())]
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")


def formatted(value: Any) -> str:
    """Write a value of a table; a missing one as a dash."""
    if isinstance(value, float):
        return f"{value:.4g}" if math.isfinite(value) else "-" if math.isnan(value) else str(value)
    return str(value)


AXES = ("x", "y", "z")


def write_points(
    path: Path, points: np.ndarray, velocities: np.ndarray | None = None, offsets: np.ndarray | None = None
) -> None:
    """Write a row per point, below a row of names: strand, x, y, z [m], vx, vy, vz [m/s]; numbers in full precision.

    points      [m], (n, 3)
    velocities  [m/s], (n, 3); without them the table has no such columns
    offsets     strand s owns points offsets[s]:offsets[s+1], (S+1,); without them there is no column strand
    """
    names, columns, formats = [], [], []
    if offsets is not None:
        names = ["strand"]
        columns = [np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))]
        formats = ["%d"]
    for prefix, vectors in (("", points), ("v", velocities)):
        if vectors is not None:
            names += [prefix + axis for axis in AXES]
            columns.append(vectors)
            formats += ["%.9g" if vectors.dtype == np.float32 else "%.17g"] * 3  # digits that represent all exactly
    header = ",".join(names)
    np.savetxt(path, np.column_stack(columns), formats, delimiter=",", header=header, comments="", encoding="utf-8")


def write_npz(path: Path, value: Any) -> None:
    """Write every array, number and text of a value under its dotted name; None is omitted.

    The same value gives the same bytes. Raises TypeError for other types.
    """
    with ZipFile(path, "w") as archive:
        for name, array in arrays(take_apart(value)):
            with archive.open(ZipInfo(f"{name}.npy"), "w", force_zip64=True) as file:
                np.lib.format.write_array(file, array, allow_pickle=False)


def arrays(tree: Tree, name: str = "") -> Iterator[tuple[str, np.ndarray]]:
    """Walk a tree that `take_apart` gives: dotted names and arrays, numbers and texts as arrays too."""
    if isinstance(tree, dict):
        for key, item in tree.items():
            yield from arrays(item, f"{name}.{key}" if name else key)
    elif isinstance(tree, tuple):
        yield name, np.array(tree, dtype=str)
    elif tree is not None:
        yield name, np.asarray(tree)


TREES = (".h5", ".hdf5", ".npz")
SUFFIXES = (*TREES, ".csv", ".usd", ".usda", ".usdc")


def write_value(path: Path, value: Any, frame: int, fps: float) -> None:
    """Write a value, whole or not at all; CSV and USD of a body hold its mesh at rest.

    frame  frame of the value, and frames per second, for formats with time

    Raises BadInput for an unknown suffix, or one that does not support the value, OSError for a path without access.
    """
    suffix = path.suffix.lower()
    shape = value.mesh if isinstance(value, Body) else value
    table = value if isinstance(value, Table) and suffix == ".csv" else None
    if suffix not in SUFFIXES:
        raise BadInput(f"values are not written as {suffix or 'such'} files", where=path, right=", ".join(SUFFIXES))
    if suffix not in TREES and table is None and not isinstance(shape, Mesh | Strands | Groom):
        raise BadInput(f"a {type(value).__name__} has no points to write", where=path, right=".h5 or .npz")
    path.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(dir=path.parent, prefix=".hairpipe-") as folder:
        whole = Path(folder, f"value{suffix}")
        if suffix in TREES:
            write_npz(whole, value) if suffix == ".npz" else encode(value, whole)
        elif table is not None:
            write_csv(whole, table)
        elif suffix == ".csv":
            write_points(whole, shape.points, *(getattr(shape, name, None) for name in ("velocities", "offsets")))
        else:
            from hairpipe.formats.usd.shot import write_still

            write_still(whole, shape, frame, fps)
        whole.replace(path)
