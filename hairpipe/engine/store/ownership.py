"""Ownership of folders: code and decisions of a user are kept in folders of his own; results of others need his trust.

Those folders lie outside of every project, so that no graph and no archive can have written to them.
"""

import errno
import os
import stat
from pathlib import Path
from typing import Literal

from hairpipe.errors import BadInput

TRUST = "HAIRPIPE_TRUST_STORE"
"""Variable that names stores of others to take results from, as a list of paths."""
OTHERS = stat.S_IWGRP | stat.S_IWOTH
EVERYBODY = stat.S_IWOTH
BASES = {
    "cache": ("XDG_CACHE_HOME", ".cache"),
    "config": ("XDG_CONFIG_HOME", ".config"),
    "state": ("XDG_STATE_HOME", ".local/state"),
}
"""Variable that says where, and the place below the home folder without it, after the XDG base directories."""


def own_folder(kind: Literal["cache", "config", "state"]) -> Path:
    """Name the user's folder for data that can be recomputed (cache), decisions (config), or records (state).

    OSError where the user has no home: then there is no such folder.
    """
    variable, usual = BASES[kind]
    home = Path(os.path.expanduser("~"))  # noqa: PTH111 - no error without
    given = Path(os.environ.get(variable, ""))
    if not home.is_absolute() and not given.is_absolute():
        raise FileNotFoundError(errno.ENOENT, "no home folder")
    return (given if given.is_absolute() else home / usual) / "hairpipe"


def make_own(folder: Path) -> None:
    """Make a folder, and the one above it, that others may not even read; OSError where that cannot be."""
    folder.parent.parent.mkdir(parents=True, exist_ok=True)
    for place in (folder.parent, folder):
        place.mkdir(mode=0o700, exist_ok=True)


def fault_of(path: Path) -> str | None:
    """Say why a path may be somebody else's; None where only this user can have written it, or it is missing."""
    try:
        status = path.lstat()
    except FileNotFoundError:
        return None
    if stat.S_ISLNK(status.st_mode):
        return "is a link"
    if status.st_uid != os.geteuid():
        return "belongs to somebody else"
    return "can be written to by others" if status.st_mode & OTHERS else None


def check_store(root: Path) -> None:
    """Refuse a store that a stranger owns, or to which everybody may write, unless it is trusted.

    A stranger is a user who shares the store with no group of this user. Nothing in a store is executed, but results
    of others would be taken for ours. Root may change any file anyway.
    """
    try:
        status = root.stat()
    except OSError:  # there is none yet, or whoever uses it says why not
        return
    trusted = [Path(path).resolve() for path in os.environ.get(TRUST, "").split(os.pathsep) if path]
    if root.resolve() in trusted:
        return
    right = f"a --cache of your own, or {TRUST}={root.resolve()} where you trust its results"
    is_shared = status.st_mode & stat.S_IWGRP and status.st_gid in (os.getegid(), *os.getgroups())
    if status.st_uid not in (os.geteuid(), 0) and not is_shared:
        what = f"a store of user {status.st_uid}, to which no group of yours may write"
        raise BadInput(what, where=root, right=right)
    if status.st_mode & EVERYBODY:
        raise BadInput("a store to which everybody may write", where=root, right=right)
