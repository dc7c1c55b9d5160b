"""What an OpenVDB file says about its grids, read without OpenVDB.

OpenVDB's own reader trusts the counts in a file: a damaged one can make it ask for all memory. Nothing but headers is
read here, so that a file can be checked where OpenVDB is not installed. Layout after OpenVDB's Archive, GridDescriptor
and MetaMap, file versions 222 (2014) on.
"""

import os
import struct
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np

from hairpipe.errors import BadInput

MAGIC = 0x56444220
OLDEST = 222
UUID = slice(21, 57)
# struct formats of the metadata that is read; of other types only the size is.
VALUES = {
    "bool": "?",
    "int32": "i",
    "int64": "q",
    "float": "f",
    "double": "d",
    "vec2i": "2i",
    "vec2s": "2f",
    "vec2d": "2d",
    "vec3i": "3i",
    "vec3s": "3f",
    "vec3d": "3d",
}
Value = bool | int | float | str | tuple


class Grid(NamedTuple):
    """What a file says about one of its grids.

    name        of the grid
    grid_class  "level set", "fog volume", "staggered" or ""
    value_type  of a voxel, such as "float" or "vec3s"
    bbox        low and high corner of the active samples [units of the file], (2, 3) float64, or None
    voxel       size along each axis [units of the file], (3,) float64, or None for a warped grid
    metadata    by name; values of unknown types are left out
    """

    name: str
    grid_class: str
    value_type: str
    bbox: np.ndarray | None
    voxel: np.ndarray | None
    metadata: dict[str, Value]


class Cursor:
    """Reads a file forward, and complains with the place where it ends too soon or makes no sense."""

    def __init__(self, file: BinaryIO, path: Path) -> None:
        self.file, self.path = file, path
        self.size = os.fstat(file.fileno()).st_size

    def fail(self, what: str, right: str = "an OpenVDB file") -> BadInput:
        """Return the error for the place reached."""
        return BadInput(what, where=f"{self.path}, byte {self.file.tell()}", right=right)

    def bytes(self, count: int) -> bytes:
        """Return the next bytes."""
        if count > self.size - self.file.tell():
            raise self.fail(f"the file ends where {count} bytes should follow")
        return self.file.read(count)

    def numbers(self, form: str) -> tuple:
        """Return the next numbers, by a struct format."""
        return struct.unpack(f"<{form}", self.bytes(struct.calcsize(f"<{form}")))

    def number(self, form: str) -> int:
        """Return the next number."""
        return self.numbers(form)[0]

    def text(self) -> str:
        """Return the next text, which its length precedes."""
        return self.bytes(self.number("I")).decode("utf-8", errors="replace")

    def seek(self, place: int) -> None:
        """Go on at a place that must lie ahead."""
        if not self.file.tell() <= place <= self.size:
            raise self.fail(f"the next grid should be at byte {place} of {self.size}")
        self.file.seek(place)


def inspect(path: Path) -> list[Grid]:
    """Return what an OpenVDB file says about its grids; raises BadInput where it is none, or damaged."""
    try:
        # Numbers of a damaged file may overflow; they are no reason to warn.
        with path.open("rb") as file, np.errstate(all="ignore"):
            return read_grids(Cursor(file, path))
    except OSError as error:
        raise BadInput(error.strerror or str(error), where=path, right="a readable OpenVDB file") from error


def read_grids(cursor: Cursor) -> list[Grid]:
    """Return the grids of a file, from its first byte on."""
    if cursor.number("q") != MAGIC:
        raise cursor.fail("this is no OpenVDB file")
    version, _, _ = cursor.numbers("3I")
    if version < OLDEST:
        raise cursor.fail(f"the file has version {version}", f"version {OLDEST} or later")
    if not cursor.number("?"):
        raise cursor.fail("the file was written as a stream, without a table of its grids", "a file that OpenVDB saved")
    cursor.bytes(UUID.stop - UUID.start)
    read_metadata(cursor)
    return [read_grid(cursor) for _ in range(checked_count(cursor, 36))]


def checked_count(cursor: Cursor, least: int) -> int:
    """Return a count of things that take at least so many bytes each."""
    count = cursor.number("I")
    if count * least > cursor.size - cursor.file.tell():
        raise cursor.fail(f"{count} entries are announced, more than the file has room for")
    return count


def read_grid(cursor: Cursor) -> Grid:
    """Return the next grid, and go to its end."""
    name, kind, _ = cursor.text(), cursor.text(), cursor.text()
    start, _, end = cursor.numbers("3q")
    cursor.seek(start)
    cursor.number("I")
    metadata = read_metadata(cursor)
    matrix = read_matrix(cursor)
    cursor.seek(end)
    parts = kind.split("_")
    return Grid(
        # OpenVDB numbers grids of one name behind this character.
        name.split("\x1e")[0],
        str(metadata.get("class", "")).replace("unknown", ""),
        parts[1] if len(parts) > 1 else kind,
        box_of(metadata, matrix),
        None if matrix is None else np.linalg.norm(matrix[:3, :3], axis=1),
        metadata,
    )


def read_metadata(cursor: Cursor) -> dict[str, Value]:
    """Return the metadata that follows, by name."""
    found: dict[str, Value] = {}
    for _ in range(checked_count(cursor, 12)):
        name, kind = cursor.text(), cursor.text()
        data = cursor.bytes(cursor.number("I"))
        if kind == "string":
            found[name] = data.decode("utf-8", errors="replace")
        elif kind in VALUES and len(data) == struct.calcsize(f"<{VALUES[kind]}"):
            value = struct.unpack(f"<{VALUES[kind]}", data)
            found[name] = value[0] if len(value) == 1 else value
    return found


def read_matrix(cursor: Cursor) -> np.ndarray | None:
    """Return the matrix from index to world, (4, 4) float64, row vectors; None for a map that is no matrix."""
    kind = cursor.text()
    matrix = np.eye(4)
    if kind in ("AffineMap", "UnitaryMap"):
        return np.array(cursor.numbers("16d")).reshape(4, 4)
    if "Translat" in kind:
        matrix[3, :3] = cursor.numbers("3d")
    if "Scale" in kind:
        matrix[:3, :3] = np.diag(cursor.numbers("3d"))
    return None if kind == "NonlinearFrustumMap" else matrix


def box_of(metadata: dict[str, Value], matrix: np.ndarray | None) -> np.ndarray | None:
    """Return the box around the active samples in world units, (2, 3), where the metadata tells it."""
    low, high = metadata.get("file_bbox_min"), metadata.get("file_bbox_max")
    if matrix is None or not isinstance(low, tuple) or not isinstance(high, tuple):
        return None
    ends = np.array([low, high], float)
    corners = np.array([[*ends[[i, j, k], range(3)], 1.0] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) @ matrix
    return np.array([corners[:, :3].min(axis=0), corners[:, :3].max(axis=0)])
