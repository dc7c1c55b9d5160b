"""Atomic files: written under a temporary name, flushed to disk, then renamed.

A temporary file is named after the process that makes it, and renewed while it is in the making. So any process can
detect left-over files: those of processes of this machine that have ended, and those that were not renewed for a day.
Names are random, and files are created, never followed through links.

A network file system may lose a file between its opening and its reading: whatever reads or writes the store is
`reopening`.
"""

import errno
import io
import os
import shutil
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import wraps
from pathlib import Path
from typing import IO, ParamSpec, TypeVar

from hairpipe.engine.store.holder import has_ended, make_name, renewal

STALE = 24 * 3600.0
"""Time without a renewal after which a temporary file is left over, by the clock of its file system [s]."""
SHARED = stat.S_ISGID | stat.S_IWGRP
"""Permissions of a folder whose files belong to its group."""
GROUP = stat.S_IRGRP | stat.S_IWGRP

REOPENINGS = 3
"""Number of times that a file is opened again after a stale handle."""

_PREFIX, _SUFFIX = ".hairpipe-", ".tmp"
P = ParamSpec("P")
T = TypeVar("T")


def reopening(act: Callable[P, T]) -> Callable[P, T]:
    """Return a function that does the same and begins again after a stale file handle, three times at most.

    NFS loses the handle of a file that another machine has replaced or removed; to open the path again finds the new
    file, or none.
    """

    @wraps(act)
    def call(*given: P.args, **named: P.kwargs) -> T:
        for _ in range(REOPENINGS):
            try:
                return act(*given, **named)
            except OSError as error:
                if error.errno != errno.ESTALE:
                    raise
        return act(*given, **named)

    return call


@contextmanager
def making(folder: Path) -> Iterator[tuple[Path, int]]:
    """Yield an empty file with a unique name, and its descriptor; it is removed if it is still there at the end.

    A folder of the same name but for the suffix `.work` belongs to it. The folder around is made where it is missing.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{_PREFIX}{make_name()}{_SUFFIX}"
    handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)
    renewal.add(handle)
    try:
        share(path, folder)
        yield path, handle
    finally:
        renewal.discard(handle)
        os.close(handle)
        _remove(path)


def share(path: Path, folder: Path) -> None:
    """Let the group write to a new file or folder, whatever the umask, where it is made in a folder of a group."""
    mode = folder.stat().st_mode
    if mode & SHARED == SHARED:
        with suppress(OSError):
            path.chmod(stat.S_IMODE(path.stat().st_mode) | (stat.S_IMODE(mode) if path.is_dir() else GROUP))


@contextmanager
def workspace(folder: Path) -> Iterator[Path]:
    """Make an empty folder within another; it goes at the end, with all that was left in it."""
    with making(folder) as (token, _):
        work = token.with_suffix(".work")
        work.mkdir()
        share(work, folder)
        yield work


@contextmanager
def replacing(path: Path, folder: Path | None = None, *, lasting: bool = True) -> Iterator[Path]:
    """Give a temporary path to write to; it becomes `path` once its bytes are on disk, or is removed on an error.

    folder   of the temporary file, on the same file system; that of `path` by default
    lasting  False: do not wait for the disk; a crash of the machine may leave the file damaged
    """
    with making(folder or path.parent) as (temporary, handle):
        yield temporary
        if lasting:
            flush(temporary)
        if not is_at(handle, temporary):
            raise OSError(errno.ESTALE, "another process has replaced the file", str(temporary))
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.replace(path)


def open_made(path: Path) -> IO[bytes]:
    """Open a file in the making to write it from the start; OSError where it has become a link."""
    return os.fdopen(os.open(path, os.O_WRONLY | os.O_TRUNC | os.O_NOFOLLOW | os.O_CLOEXEC), "wb")


def flush(path: Path) -> None:
    """Wait until the bytes of a file are on disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def keep_mode(temporary: Path, path: Path) -> None:
    """Give a file in the making the permissions of the file that it replaces; nothing where there is none."""
    with suppress(OSError):
        found = path.lstat()
        if stat.S_ISREG(found.st_mode):
            temporary.chmod(found.st_mode & 0o777)


def overwrite(path: Path, data: bytes) -> None:
    """Write other bytes into a file that is there, whose links and owner stay; what was there is put back on an error.

    It is not atomic: a crash of the machine may leave the file damaged.
    """
    with path.open("r+b", buffering=0) as file:
        before = file.read()
        try:
            _fill(file, data)
        except OSError:
            _fill(file, before)
            raise


def _fill(file: io.FileIO, data: bytes) -> None:
    file.seek(0)
    written = 0
    while written < len(data):
        written += file.write(data[written:])
    file.truncate()
    os.fsync(file.fileno())


@reopening
def write_text(path: Path, text: str, folder: Path | None = None, *, lasting: bool = True) -> None:
    """Write a text file atomically; see `replacing`."""
    with replacing(path, folder, lasting=lasting) as temporary, open_made(temporary) as file:
        file.write(text.encode("utf-8"))
        file.flush()
        keep_mode(temporary, path)


def sweep(folder: Path) -> int:
    """Remove left-over temporary files, and the folders that belong to them; returns how many."""
    swept = 0
    with suppress(OSError):
        for path in folder.glob(f"{_PREFIX}*{_SUFFIX}"):
            swept += is_left_over(path) and _remove(path)
    return swept


def is_left_over(path: Path) -> bool:
    """Whether a file is a left-over temporary one."""
    name = path.name.removeprefix(_PREFIX).removesuffix(_SUFFIX)
    try:
        return stat.S_ISREG(path.lstat().st_mode) and (has_ended(name) or is_stale(path))
    except OSError:  # it has just gone
        return False


def is_stale(path: Path) -> bool:
    """Whether a file was not renewed for a day."""
    return now_in(path.parent) - path.lstat().st_mtime > STALE


def now_in(folder: Path) -> float:
    """Read the clock of the file system of a folder, with which stamps of its files are compared, in s since 1970.

    That of this machine may differ. OSError where nothing can be written there.
    """
    with making(folder) as (_, handle):
        return os.fstat(handle).st_mtime


def is_at(handle: int, path: Path) -> bool:
    """Whether an open file still lies at a path, itself and no link to it."""
    try:
        return os.path.samestat(os.fstat(handle), path.lstat())
    except OSError:
        return False


def _remove(path: Path) -> bool:
    """Remove a temporary file, after the folder that belongs to it; whether that went."""
    work = path.with_suffix(".work")
    shutil.rmtree(work, ignore_errors=True)
    with suppress(OSError):
        if not os.path.lexists(work):
            discard(path)
    return not os.path.lexists(path)


def discard(path: Path) -> None:
    """Remove a file, or a folder that stands in its place; a link goes itself."""
    shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink(missing_ok=True)
