"""What a path leads to where it is neither a file nor a folder: what may never end, or act when it is opened."""

import os
import stat
from pathlib import Path

from hairpipe.errors import BadInput

SYSTEM = ("/proc", "/sys")
"""Where files are no files: reading one may wait for ever (`/proc/kmsg`), or give what has no end."""
KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def special(path: Path) -> str | None:
    """Say what a path leads to that is never read or replaced; None for a file, a folder, or nothing.

    OSError or ValueError where a path cannot be asked about.
    """
    try:
        kind = KINDS.get(stat.S_IFMT(path.stat().st_mode))
    except (FileNotFoundError, NotADirectoryError):
        return None
    inside = any(Path(os.path.realpath(path)).is_relative_to(place) for place in SYSTEM)
    return kind or ("part of the system" if inside else None)


def check_plain(path: Path, right: str) -> None:
    """Refuse what is neither a file, a folder, nor nothing; BadInput says what it is, and what would be right."""
    kind = special(path)
    if kind:
        raise BadInput(f"it is {kind}", where=path, right=right)
