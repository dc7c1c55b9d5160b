"""Folders of the user's own, outside of every project: what is in them, no graph and no archive can have put there."""

import errno
import os
import stat
from pathlib import Path
from typing import Literal

OTHERS = stat.S_IWGRP | stat.S_IWOTH
BASES = {"config": ("XDG_CONFIG_HOME", ".config"), "state": ("XDG_STATE_HOME", ".local/state")}
"""Variable that says where, and the place below the home folder without it, after the XDG base directories."""


def own_folder(kind: Literal["config", "state"]) -> Path:
    """Name the folder of this user for what he has decided (config) or what we have done for him (state).

    OSError where he has no home: then there is no such folder, and none must be taken for it.
    """
    variable, usual = BASES[kind]
    home, told = Path(os.path.expanduser("~")), Path(os.environ.get(variable, ""))  # noqa: PTH111 - no error without
    if not home.is_absolute() and not told.is_absolute():
        raise FileNotFoundError(errno.ENOENT, "no home folder")
    return (told if told.is_absolute() else home / usual) / "hairpipe"


def make_own(folder: Path) -> None:
    """Make a folder within one of the user's own, which others may not even read; OSError where that cannot be."""
    for place in (folder.parent, folder):
        place.mkdir(mode=0o700, parents=True, exist_ok=True)


def fault_of(path: Path) -> str | None:
    """Say why what lies there may be somebody else's; None where only this user can have written it, or nothing is."""
    try:
        status = path.lstat()
    except FileNotFoundError:
        return None
    if stat.S_ISLNK(status.st_mode):
        return "is a link"
    if status.st_uid != os.geteuid():
        return "belongs to somebody else"
    return "can be written to by others" if status.st_mode & OTHERS else None
