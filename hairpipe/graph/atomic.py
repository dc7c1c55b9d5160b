"""Files appear whole or not at all: a temporary name, the bytes on disk, then a rename.

A process that is killed in between leaves a temporary file that carries its process number; the next one sweeps it.
"""

import itertools
import os
import re
import shutil
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

HOST = re.sub(r"[^A-Za-z0-9]", "", socket.gethostname()) or "host"
STALE = 24 * 3600.0
"""Age after which a temporary file of another machine is taken for left over [s]."""

_NAME = re.compile(r"\.hairpipe-([A-Za-z0-9]+)-(\d+)-\d+\.tmp")
"""Of a temporary file, a name that nobody else gives: machine, process, number."""
_counter = itertools.count()


def temporary_name(folder: Path) -> Path:
    """Give a name in the folder that no other process uses; the folder is made where it is missing."""
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f".hairpipe-{HOST}-{os.getpid()}-{next(_counter)}.tmp"


@contextmanager
def replacing(path: Path, folder: Path | None = None, *, lasting: bool = True) -> Iterator[Path]:
    """Give a temporary path to write to; it becomes `path` once its bytes are on disk, or is removed on an error.

    folder   of the temporary file, on the same file system; that of `path` by default
    lasting  False: do not wait for the disk; a crash of the machine may leave the file damaged
    """
    temporary = temporary_name(folder or path.parent)
    try:
        yield temporary
        if lasting:
            flush(temporary)
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.replace(path)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def flush(path: Path) -> None:
    """Wait until the bytes of a file are on disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def write_text(path: Path, text: str, folder: Path | None = None, *, lasting: bool = True) -> None:
    """Write a text file atomically; see `replacing`."""
    with replacing(path, folder, lasting=lasting) as temporary:
        temporary.write_text(text, encoding="utf-8")


def sweep(folder: Path, *, ours_alone: bool = False) -> int:
    """Remove temporary files and folders whose process is gone; returns how many.

    ours_alone  nobody else uses the folder: what processes of other machines left goes too, after a day
    """
    swept = 0
    with suppress(OSError):
        for path in folder.glob("*.tmp"):
            if is_left_over(path, elsewhere=ours_alone):
                shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink(missing_ok=True)
                swept += 1
    return swept


def is_left_over(path: Path, *, elsewhere: bool = False) -> bool:
    """Whether a file is a temporary one of ours, and the process that made it gone, as far as this machine can tell.

    elsewhere  judge files of other machines by their age
    """
    name = _NAME.fullmatch(path.name)
    if name is None:
        return False
    host, process = name.groups()
    if host == HOST:
        return not is_running(int(process))
    return elsewhere and time.time() - path.stat().st_mtime > STALE


def is_running(process: int) -> bool:
    """Whether a process of this machine runs; one that is dead and waits to be noticed does not."""
    try:
        os.kill(process, 0)
        status = Path(f"/proc/{process}/stat").read_text()
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True
    return status.rpartition(")")[2].split()[0] not in ("Z", "X")
