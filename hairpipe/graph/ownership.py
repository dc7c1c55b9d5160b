"""Whose a folder is: compiled kernels are code and need one of the user's own, results of others are to be trusted."""

import os
import stat
from pathlib import Path

from hairpipe.errors import BadInput

TRUST = "HAIRPIPE_TRUST_STORE"
"""Variable that names stores of others to take results from, as a list of paths."""
GROUP_OR_OTHERS, OTHERS = stat.S_IWGRP | stat.S_IWOTH, stat.S_IWOTH


def own_folder(folder: Path) -> Path:
    """Make a folder that this user alone can write to, or check that one is; returns it.

    Raises BadInput where it is somebody else's or others may write to it, OSError where there can be none.
    """
    if not folder.is_absolute():
        raise FileNotFoundError(f"{folder}: no home is known")
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)
    status = folder.stat()
    if status.st_uid != os.geteuid():
        raise BadInput(f"belongs to user {status.st_uid}", where=folder, right="a folder of your own for kernels")
    if status.st_mode & GROUP_OR_OTHERS:
        raise BadInput("others may write compiled kernels to it", where=folder, right=f"chmod go-w {folder}")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"{folder} cannot be written to")
    return folder


def check_store(root: Path) -> None:
    """Refuse a store that another user owns, or to which everybody may write, unless it is trusted.

    Nothing in a store is executed, but results of others would be taken for ours. Root may change any file anyway.
    """
    try:
        status = root.stat()
    except OSError:  # there is none yet, or whoever uses it says why not
        return
    trusted = [Path(path).resolve() for path in os.environ.get(TRUST, "").split(os.pathsep) if path]
    if root.resolve() in trusted:
        return
    right = f"a --cache of your own, or {TRUST}={root.resolve()} where you trust its results"
    if status.st_uid not in (os.geteuid(), 0):
        raise BadInput(f"a store of user {status.st_uid}", where=root, right=right)
    if status.st_mode & OTHERS:
        raise BadInput("a store to which everybody may write", where=root, right=right)
