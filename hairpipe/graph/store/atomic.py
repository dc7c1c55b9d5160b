"""Atomic files: written under a temporary name, flushed to disk, then renamed.

A temporary file is locked (flock) by the process that makes it. The kernel releases a lock when its process ends,
however it ends, so any process can detect and remove left-over files. Process numbers would not do, since containers
of one host name count their own. Names are random, and files are created, never followed through links.
"""

import errno
import fcntl
import io
import os
import re
import secrets
import shutil
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

STALE = 24 * 3600.0
"""Age after which a temporary file counts as left over where the file system has no locks [s]."""

_NAME = re.compile(r"\.hairpipe-(?:([0-9a-f]{32})|[A-Za-z0-9]+-\d+-\d+)\.tmp")
"""Unique name of a temporary file; older versions wrote machine, process and number."""
_NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL, errno.EBADF)
_held: set[int] = set()
"""Descriptors of the files that this process has in the making."""


def _let_go() -> None:
    """Close the temporary files of the parent in a forked process: their locks belong to the parent."""
    for handle in _held:
        with suppress(OSError):
            os.close(handle)
    _held.clear()


os.register_at_fork(after_in_child=_let_go)


@contextmanager
def making(folder: Path) -> Iterator[tuple[Path, int]]:
    """Yield an empty locked file with a unique name, and its descriptor; it is removed if it is still there at the end.

    A folder of the same name but for the suffix `.work` belongs to it. The folder around is made where it is missing.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path, handle = _create(folder)
    _held.add(handle)
    try:
        yield path, handle
    finally:
        _remove(path)
        if handle in _held:  # in a fork it is closed already
            _held.discard(handle)
            os.close(handle)


def _create(folder: Path) -> tuple[Path, int]:
    """Create a file and lock it."""
    while True:
        path = folder / f".hairpipe-{secrets.token_hex(16)}.tmp"
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
        handle = os.open(path, flags, 0o666)
        if _lock(handle) is not False and is_at(handle, path):
            return path, handle
        os.close(handle)  # a sweep came before the lock, and takes the file


@contextmanager
def workspace(folder: Path) -> Iterator[Path]:
    """Make an empty folder within another; it goes at the end, with all that was left in it."""
    with making(folder) as (token, _):
        work = token.with_suffix(".work")
        work.mkdir()
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


def write_text(path: Path, text: str, folder: Path | None = None, *, lasting: bool = True) -> None:
    """Write a text file atomically; see `replacing`."""
    with replacing(path, folder, lasting=lasting) as temporary, open_made(temporary) as file:
        file.write(text.encode("utf-8"))
        file.flush()
        keep_mode(temporary, path)


def sweep(folder: Path, *, ours_alone: bool = False) -> int:
    """Remove left-over temporary files, and the folders that belong to them; returns how many.

    ours_alone  the folder is used by hairpipe alone: files without a lock are removed too, after a day
    """
    swept = 0
    with suppress(OSError):
        for path in folder.glob(".hairpipe-*.tmp"):
            with left_over(path, elsewhere=ours_alone) as gone:
                swept += gone and _remove(path)
    return swept


def is_left_over(path: Path, *, elsewhere: bool = False) -> bool:
    """Whether a file is a left-over temporary one of ours; `elsewhere` as below."""
    with left_over(path, elsewhere=elsewhere) as gone:
        return gone


@contextmanager
def left_over(path: Path, *, elsewhere: bool = False) -> Iterator[bool]:
    """Tell whether a file is a left-over temporary one of ours, and hold its lock meanwhile.

    elsewhere  judge files by their age where there are no locks
    """
    name = _NAME.fullmatch(path.name)
    handle = None
    gone = False
    try:
        if name is not None:
            old = elsewhere and time.time() - path.lstat().st_mtime > STALE
            handle = _open(path) if name[1] else None
            locked = None if handle is None else _lock(handle)
            gone = (handle is None or is_at(handle, path)) and (old if locked is None else locked)
    except OSError:  # it has just gone, or is a link or a folder, and so none of ours
        gone = False
    try:
        yield gone
    finally:
        if handle is not None:
            os.close(handle)


def _open(path: Path) -> int:
    flags = os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
    try:
        return os.open(path, os.O_RDWR | flags)  # some file systems lock only what may be written
    except PermissionError:
        return os.open(path, os.O_RDONLY | flags)


def _lock(handle: int) -> bool | None:
    """Take the lock of an open file; False where somebody has it, None where there are no locks."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno in _NO_LOCKS:
            return None
        raise
    return True


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
