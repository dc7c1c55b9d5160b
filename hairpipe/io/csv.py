"""Points as CSV tables, for spreadsheets and plots."""

from pathlib import Path

import numpy as np

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
            formats += [f"%.{digits(vectors)}g"] * 3
    header = ",".join(names)
    np.savetxt(path, np.column_stack(columns), formats, delimiter=",", header=header, comments="", encoding="utf-8")


def digits(array: np.ndarray) -> int:
    """Return the number of digits that represents every number of the array exactly."""
    return 9 if array.dtype == np.float32 else 17
