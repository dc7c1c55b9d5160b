"""A layer between this process and the file system: every call on files of some folders can be counted, or disturbed.

It replaces functions of the module os, the function open, and the reading and writing of HDF5 files, whose library
calls the system by itself. What is read and written through an open file of Python is part of its opening.
"""

import builtins
import io
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple, Self

from hairpipe.formats import hdf5

READING = ("access", "fstat", "listdir", "lstat", "open", "read", "readlink", "scandir", "stat")
WRITING = (
    *("chmod", "chown", "fchmod", "fsync", "ftruncate", "link", "mkdir", "remove", "rename", "replace"),
    *("rmdir", "symlink", "truncate", "unlink", "utime", "write"),
)
MOVING = ("rename", "replace")
MODES = frozenset("wax+")
"""Letters in the mode of an opened file that is written to."""


class Call(NamedTuple):
    """A call of the file system.

    name    of the function
    path    of its file, below the folder that the layer is about
    writes  whether it changes anything
    target  new path of a file that is renamed
    """

    name: str
    path: str
    writes: bool
    target: str | None = None


class FileLayer:
    """The layer, while it is entered.

    folders  whose files it is about
    before   is called before each call, and may raise in its place
    """

    def __init__(self, folders: tuple[Path, ...], before: Callable[[Call], None]) -> None:
        self._roots = tuple(f"{folder.resolve()}/" for folder in folders)
        self._before = before
        self._replaced: list[tuple[ModuleType, str, Any]] = []

    def __enter__(self) -> Self:
        """Replace the functions."""
        for name in (*READING, *WRITING):
            self._replace(os, name, self._layered(getattr(os, name), name, name in WRITING))
        opened = self._layered_open(io.open)
        self._replace(io, "open", opened)
        self._replace(builtins, "open", opened)
        self._replace(hdf5, "read", self._layered(hdf5.read, "HDF5 read", False))
        self._replace(hdf5, "write", self._layered(hdf5.write, "HDF5 write", True, at=1))
        return self

    def __exit__(self, *error: object) -> None:
        """Put them back."""
        for module, name, function in reversed(self._replaced):
            setattr(module, name, function)

    def _replace(self, module: ModuleType, name: str, function: Any) -> None:
        self._replaced.append((module, name, getattr(module, name)))
        setattr(module, name, function)

    def _layered(self, function: Callable[..., Any], name: str, writes: bool, at: int = 0) -> Callable[..., Any]:
        """Call a function through the layer; `at` is the place of the path among its arguments."""

        def layered(*given: Any, **named: Any) -> Any:
            subject = given[at] if len(given) > at else "."
            path = self._path_within(subject, named.get("dir_fd"))
            if path is not None:
                opened = name == "open" and bool(given[1] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT))
                target = self._path_within(given[1], None) if name in MOVING else None
                self._before(Call(name, path, writes or opened, target))
            return function(*given, **named)

        return layered

    def _layered_open(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def layered(file: Any, mode: str = "r", *given: Any, **named: Any) -> Any:
            path = None if isinstance(file, int) else self._path_within(file, None)
            if path is not None:
                self._before(Call("open file", path, not MODES.isdisjoint(mode)))
            return function(file, mode, *given, **named)

        return layered

    def _path_within(self, subject: Any, folder: int | None) -> str | None:
        """Find the path of a file by name or descriptor, below the folders; None for others."""
        path = None
        with suppress(OSError, TypeError, ValueError):
            path = _path_of(subject) if isinstance(subject, int) else os.fsdecode(subject)
            if folder is not None:
                path = f"{_path_of(folder)}/{path}"
            path = os.path.normpath(Path.cwd() / path)
        for root in self._roots:
            if path is not None and f"{path}/".startswith(root):
                return path[len(root) :]
        return None


def _path_of(descriptor: int, readlink: Callable[[str], str] = os.readlink) -> str:
    """Find the path of an open file."""
    return readlink(f"/proc/self/fd/{descriptor}")
