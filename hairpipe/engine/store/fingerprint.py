"""Digests of files by their bytes, cached as long as the file is provably unchanged; seals of compiled kernels.

Numba stores kernels as pickles and loads them unchecked. The seal, a digest of the bytes and of the names of file and
folder, follows the pickle in the same file, which is written atomically, so that any number of processes may write and
be killed; numba alone can read such a file, too. A file with a wrong seal, or without one, is removed, and numba
compiles again.
"""

import json
import time
from contextlib import suppress
from pathlib import Path

from hairpipe.engine.store.atomic import discard, reopening
from hairpipe.engine.store.digest import DIGEST_BYTES, digest, hasher, parsed
from hairpipe.engine.store.store import Store
from hairpipe.plain_file import Stamp, stamp_of

CHUNK = 1 << 20
SETTLED = 2_000_000_000
"""A file that changed less than this before it was digested may change again within one tick of its clock [ns]."""


def fingerprint(path: Path, store: Store) -> str:
    """Digest the bytes of a file; OSError where it cannot be read.

    The store caches it by device, inode, size, modification and status change: the last one is set by the kernel
    alone, so that a copied or back-dated file is read again.
    """
    path = path.absolute()
    name = digest("stat", str(path))
    begun = time.time_ns()
    stamp = stamp_of(str(path))
    with suppress(ValueError, TypeError, KeyError):  # no note, or a foreign one
        known = parsed(store.recall(name) or "null")
        if tuple(known["stamp"]) == stamp and is_settled(stamp, known["begun"]):
            return str(known["digest"])
    found = digest_file(path)
    if stamp_of(str(path)) == stamp:
        store.note(name, json.dumps({"stamp": stamp, "begun": begun, "digest": found}))
    return found


def is_settled(stamp: Stamp, begun: int) -> bool:
    """Whether a file that is read from a time on [ns] has another stamp as soon as its bytes change."""
    return begun - max(stamp[-2:]) > SETTLED


@reopening
def digest_file(path: Path) -> str:
    """Digest the bytes of a file."""
    state = hasher("file")
    with path.open("rb") as file:
        while chunk := file.read(CHUNK):
            state.update(chunk)
    return state.hexdigest()


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
