"""Checksums of compiled kernels: numba stores them as pickles and loads them unchecked.

The digest, of the bytes and of the names of file and folder, follows the pickle in the same file, which is written
atomically, so that any number of processes may write and be killed; numba alone can read such a file, too. A file with
a wrong digest, or without one, is removed, and numba compiles again.
"""

from contextlib import suppress
from pathlib import Path

from hairpipe.engine.store.atomic import discard
from hairpipe.engine.store.digest import DIGEST_BYTES, hasher

MARK = b"\nhairpipe "
LENGTH = len(MARK) + DIGEST_BYTES

_removed: list[Path] = []


def seal(path: Path, data: bytes) -> bytes:
    """Return the seal that follows the bytes of a kernel at a path: of its bytes and its place."""
    return MARK + hasher("kernel", f"{path.parent.name}/{path.name}\0".encode() + data).digest()


def is_sealed(path: Path) -> bool:
    """Whether a kernel is as and where it was written; OSError where it cannot be read."""
    data = path.read_bytes()
    return data[-LENGTH:] == seal(path, data[:-LENGTH])


def removed() -> list[Path]:
    """Name the damaged kernels that this process has removed since the last call."""
    found = list(_removed)
    _removed.clear()
    return found


def is_there(path: Path) -> bool:
    """Whether an intact kernel is there; a damaged one is removed."""
    try:
        if is_sealed(path):
            return True
    except FileNotFoundError:
        return False
    except OSError:
        pass
    with suppress(OSError):
        discard(path)
    _removed.append(path)
    return False
