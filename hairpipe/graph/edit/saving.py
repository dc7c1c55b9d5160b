"""Writes the text of a graph file; its permissions, owner and links are kept."""

import fcntl
import hashlib
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from hairpipe.errors import BadInput
from hairpipe.graph.edit.inline_table import literal_of
from hairpipe.graph.edit.verbs import with_value
from hairpipe.graph.file.read import read_graph_text
from hairpipe.graph.store.atomic import overwrite, write_text
from hairpipe.graph.store.ownership import make_own, own_folder

BOM = "\ufeff"
PATIENCE = 10.0
"""Longest wait for another process that saves the same file [s]."""


def save_settings(path: Path, settings: Mapping[str, Any]) -> None:
    """Write settings into a graph file; BadInput as for `with_settings`."""
    with locked(path):
        save_text(path, with_settings(read_graph_text(path).text, settings))


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Lock a graph file while it is compared and written, against other processes of this user.

    The lock is a file in the state folder of the user, as the graph file itself is replaced by each write. A user
    without a home has no lock. BadInput for a lock that another process keeps.
    """
    with ExitStack() as stack:
        with suppress(OSError):
            folder = own_folder("state") / "saving"
            make_own(folder)
            name = hashlib.blake2b(os.fsencode(path.resolve()), digest_size=16).hexdigest()
            take_lock(stack.enter_context((folder / name).open("w")).fileno(), path)
        yield


def take_lock(handle: int, path: Path) -> None:
    """Lock an open file; BadInput, which names `path`, after `PATIENCE`."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > end:
                raise BadInput("another process has been saving it for long", where=path, right="try again") from None
            time.sleep(0.005)


def save_text(path: Path, text: str) -> None:
    """Write a graph file, which may be new; OSError for a file that cannot be written."""
    target = path.resolve()
    found = target.stat() if target.exists() else None
    mark = BOM if found and target.read_bytes().startswith(BOM.encode()) else ""
    if found and (found.st_nlink > 1 or found.st_uid != os.geteuid()):  # a new file would have one name, and be ours
        overwrite(target, (mark + text).encode("utf-8"))
    else:
        write_text(target, mark + text)


def with_settings(text: str, settings: Mapping[str, Any]) -> str:
    """Return the text of a graph file with settings changed, by `node.setting` or `node.group.setting`.

    BadInput if a setting cannot be set, or if the layout of the text does not permit the change.
    """
    for target, value in settings.items():
        text = with_value(text, target, literal_of(value))
    return text
