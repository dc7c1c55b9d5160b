"""Files that may be read or replaced: regular ones. Reading a device, a pipe or a log of the kernel may never end."""

import errno
import os
import stat
from collections.abc import Iterable
from operator import attrgetter
from pathlib import Path
from typing import Literal

from hairpipe.errors import BadInput

Absent = Literal["refuse", "warn"]
"""What is done where a file names another one that does not exist."""
Stamp = tuple[int, ...]
SYSTEM = ("/proc", "/sys")
"""Places of special files: reading one may wait for ever (`/proc/kmsg`), or give what has no end."""
KINDS = {
    stat.S_IFDIR: "a directory",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
}


def special_kind(found: os.stat_result) -> str | None:
    """Return what stands in the place of a regular file, or None where there is one; pure."""
    return None if stat.S_ISREG(found.st_mode) else KINDS.get(stat.S_IFMT(found.st_mode), "no file")


def special(path: Path) -> str | None:
    """Return the kind of a special file, which is never read or replaced; None for a file, a folder, or nothing.

    OSError or ValueError where a path cannot be asked about.
    """
    try:
        mode = stat.S_IFMT(path.stat().st_mode)
    except (FileNotFoundError, NotADirectoryError):
        return None
    inside = any(Path(os.path.realpath(path)).is_relative_to(place) for place in SYSTEM)
    return "part of the system" if inside else KINDS.get(mode) if mode != stat.S_IFDIR else None


def check_plain(path: Path, right: str) -> None:
    """Refuse what is neither a file, a folder, nor nothing; BadInput says what it is, and what would be right."""
    kind = special(path)
    if kind:
        raise BadInput(f"it is {kind}", where=path, right=right)


def checked_size(path: Path, right: str) -> int:
    """Return the size of a regular file [bytes]; links are followed.

    right  what would be accepted instead

    Raises BadInput where it is missing, forbidden, something else than a file, or empty: files of the kernel's own file
    systems have no size, and reading one may wait for ever.
    """
    try:
        found = Path(path).stat()
    except (OSError, ValueError) as fault:  # the latter of a name that no file can have
        raise BadInput(f"the file cannot be read: {describe_fault(fault)}", where=path, right=right) from None
    if kind := special_kind(found):
        raise BadInput(f"the file cannot be read: it is {kind}", where=path, right=right)
    if not found.st_size:
        raise BadInput("the file is empty", where=path, right=right)
    if not os.access(path, os.R_OK):
        raise BadInput(f"the file cannot be read: {os.strerror(errno.EACCES)}", where=path, right=right)
    return found.st_size


def content(path: Path, right: str, most: int | None = None) -> bytes:
    """Return what is in a regular file.

    most  size of a file that is read [bytes]; any for None

    Raises BadInput as `checked_size` does, and for a file that is larger, before it is read.
    """
    size = checked_size(path, right)
    if most is not None and size > most:
        raise BadInput(f"the file is too large: {size:,} bytes", where=path, right=f"{right} of at most {most:,} bytes")
    try:
        with Path(path).open("rb") as file:
            return file.read(size)
    except OSError as fault:
        raise BadInput(f"the file cannot be read: {describe_fault(fault)}", where=path, right=right) from None


_stamped = attrgetter("st_dev", "st_ino", "st_size", "st_mtime_ns", "st_ctime_ns")


def stamp_of(file: str) -> Stamp:
    """Return device, inode, size, modification and status change [ns] of a file or folder; nothing of a missing one."""
    try:
        found = Path(file).stat()
    except (OSError, ValueError):
        return ()
    return _stamped(found)


def describe_fault(fault: OSError | ValueError) -> str:
    return getattr(fault, "strerror", None) or str(fault)


def with_folders(files: Iterable[Path]) -> list[Path]:
    """Return files and their folders, which change where another file appears that a stage refers to; pure."""
    return list(dict.fromkeys(place for file in files for place in (file, file.parent)))
