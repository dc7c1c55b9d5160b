"""What an OpenVDB file says about its grids, read without OpenVDB.

OpenVDB's own reader trusts the counts in a file: a damaged one can make it ask for all memory. Nothing but headers is
read here, so that a file can be checked where OpenVDB is not installed. Layout after OpenVDB's Archive, GridDescriptor
and MetaMap, file versions 222 (2014) on.
"""

import os
import struct
from pathlib import Path
from typing import BinaryIO, NamedTuple

from hairpipe.errors import BadInput
from hairpipe.plain_file import checked_size

MAGIC = 0x56444220
OLDEST = 222
UUID = slice(21, 57)


class Grid(NamedTuple):
    """What a file says about one of its grids.

    name        of the grid
    grid_class  "level set", "fog volume", "staggered" or ""
    """

    name: str
    grid_class: str


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
    checked_size(path, "a readable OpenVDB file")
    try:
        with path.open("rb") as file:
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
    name, _, _ = cursor.text(), cursor.text(), cursor.text()
    start, _, end = cursor.numbers("3q")
    cursor.seek(start)
    cursor.number("I")
    kind = read_metadata(cursor).get("class", "")
    cursor.seek(end)
    # OpenVDB numbers grids of one name behind this character.
    return Grid(name.split("\x1e")[0], kind.replace("unknown", ""))


def read_metadata(cursor: Cursor) -> dict[str, str]:
    """Return the texts in the metadata that follows, by name."""
    found = {}
    for _ in range(checked_count(cursor, 12)):
        name, kind = cursor.text(), cursor.text()
        data = cursor.bytes(cursor.number("I"))
        if kind == "string":
            found[name] = data.decode("utf-8", errors="replace")
    return found
