"""Grid headers of an OpenVDB file, read without OpenVDB.

OpenVDB's own reader trusts the counts in a file: a damaged one can make it allocate all memory. Only headers are read
here, so that a file can be checked where OpenVDB is not installed. Layout after OpenVDB's Archive, GridDescriptor
and MetaMap, file versions 222 (2014) on.
"""

import os
import struct
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from hairpipe.errors import BadInput
from hairpipe.plain_file import checked_size

MAGIC = 0x56444220
OLDEST = 222
UUID = slice(21, 57)
NUMBERS = {"vec3i": "<3i", "float": "<f", "double": "<d"}
"""Layouts of metadata that are numbers, by the name of their type."""


class Grid(NamedTuple):
    """Header of one grid of a file.

    name        of the grid
    grid_class  "level set", "fog volume", "staggered" or ""
    box         lower and upper corner of its active voxels, as `hairpipe.io.vdb.vdb_write` wrote it [m]; else None
    """

    name: str
    grid_class: str
    box: tuple[tuple[float, ...], tuple[float, ...]] | None = None


class Unread(BadInput):
    """A sound file of a kind that only OpenVDB's library reads."""


class Cursor:
    """Reader of a file from begin to end; faults state the place."""

    def __init__(self, file: BinaryIO, path: Path) -> None:
        self.file, self.path = file, path
        self.size = os.fstat(file.fileno()).st_size

    def fail(self, what: str, right: str = "an OpenVDB file", kind: type[BadInput] = BadInput) -> BadInput:
        """Return the error at the current place."""
        return kind(what, where=f"{self.path}, byte {self.file.tell()}", right=right)

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
        """Return the next text, preceded by its length."""
        return self.bytes(self.number("I")).decode("utf-8", errors="replace")

    def seek(self, place: int) -> None:
        """Skip to a later place."""
        if not self.file.tell() <= place <= self.size:
            raise self.fail(f"the next grid should be at byte {place} of {self.size}")
        self.file.seek(place)


def inspect(path: Path) -> list[Grid]:
    """Return the headers of the grids of an OpenVDB file; raises BadInput for a damaged or another file."""
    checked_size(path, "a readable OpenVDB file")
    try:
        with path.open("rb") as file:
            return read_grids(Cursor(file, path))
    except OSError as error:
        raise BadInput(error.strerror or str(error), where=path, right="a readable OpenVDB file") from error


def box(path: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the corners of the box of the level set `surface` in a file of ours [m].

    Raises BadInput where the file has none, or is damaged.
    """
    found = next((grid.box for grid in inspect(path) if grid.name == "surface" and grid.box), None)
    if found is None:
        raise BadInput("the file has no level set 'surface' of known size", where=path, right="a file of export_vdb")
    return found


def read_grids(cursor: Cursor) -> list[Grid]:
    """Return the grids of a file, from its first byte on."""
    return [read_grid(cursor) for _ in range(open_archive(cursor))]


def open_archive(cursor: Cursor) -> int:
    """Read the header of a file up to its first grid; return the number of grids."""
    if cursor.number("q") != MAGIC:
        raise cursor.fail("not an OpenVDB file")
    version, _, _ = cursor.numbers("3I")
    if version < OLDEST:
        raise cursor.fail(f"the file has version {version}", f"version {OLDEST} or later", Unread)
    if not cursor.number("?"):
        what = "the file was written as a stream, without a table of its grids"
        raise cursor.fail(what, "a file that OpenVDB saved", Unread)
    cursor.bytes(UUID.stop - UUID.start)
    read_metadata(cursor)
    return checked_count(cursor, 36)


def checked_count(cursor: Cursor, least: int) -> int:
    """Return a count of items of at least `least` bytes each."""
    count = cursor.number("I")
    if count * least > cursor.size - cursor.file.tell():
        raise cursor.fail(f"{count} entries are announced, more than the file has room for")
    return count


def read_grid(cursor: Cursor) -> Grid:
    """Return the next grid, and go to its end."""
    name, _, _ = cursor.text(), cursor.text(), cursor.text()
    start, _, end = cursor.numbers("3q")
    cursor.seek(start)
    cursor.number("I")
    facts = read_metadata(cursor)
    cursor.seek(end)
    # OpenVDB appends this character and a number to repeated names.
    return Grid(name.split("\x1e")[0], str(facts.get("class", "")).replace("unknown", ""), box_of(facts))


def box_of(facts: dict[str, Any]) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Return the corners of the box of the active voxels [m], from OpenVDB's indices and our voxel size."""
    lower, upper, voxel = (facts.get(name) for name in ("file_bbox_min", "file_bbox_max", "voxel"))
    if not (lower and upper and voxel) or any(a > b for a, b in zip(lower, upper, strict=True)):
        return None
    return tuple(i * voxel for i in lower), tuple(i * voxel for i in upper)


def read_metadata(cursor: Cursor) -> dict[str, Any]:
    """Return the texts, lengths and places of the next metadata, by name."""
    found: dict[str, Any] = {}
    for _ in range(checked_count(cursor, 12)):
        name, kind = cursor.text(), cursor.text()
        data = cursor.bytes(cursor.number("I"))
        if kind == "string":
            found[name] = data.decode("utf-8", errors="replace")
        elif kind in NUMBERS and len(data) == struct.calcsize(NUMBERS[kind]):
            numbers = struct.unpack(NUMBERS[kind], data)
            found[name] = numbers if len(numbers) > 1 else numbers[0]
    return found
