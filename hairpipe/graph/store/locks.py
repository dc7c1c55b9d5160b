"""Locks of keys: one evaluation of an action at a time, among all processes that share a store.

Locks are byte ranges of one file, at an offset made of the key: the kernel releases them when a process ends, however
it ends, and nothing is left to clean up.
"""

import errno
import fcntl
import os
from contextlib import suppress
from pathlib import Path

OFFSET_DIGITS = 15
"""Hexadecimal digits of a key that make the offset: 60 bits, which a file offset can hold."""


class KeyLocks:
    """The locks that this process holds; one object per store and process, since closing the file drops them all."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: int | None = None
        self._held: set[int] = set()

    def acquire(self, key: str) -> bool:
        """Acquire the lock of a key without waiting; False where it is taken. OSError where there can be no locks."""
        offset = int(key[:OFFSET_DIGITS], 16)
        if offset in self._held:
            return False
        file = self._open()  # its errors must not be mistaken for a taken lock, which would be waited for
        try:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, offset)
        except OSError as error:
            if error.errno in (errno.EACCES, errno.EAGAIN):
                return False
            # A file system without locks: at worst an action is evaluated twice, with the same result.
        self._held.add(offset)
        return True

    def release(self, key: str) -> None:
        """Release the lock of a key."""
        offset = int(key[:OFFSET_DIGITS], 16)
        if offset in self._held and self._file is not None:
            self._held.discard(offset)
            with suppress(OSError):
                fcntl.lockf(self._file, fcntl.LOCK_UN, 1, offset)

    def close(self) -> None:
        """Release all locks."""
        if self._file is not None:
            os.close(self._file)
        self._file = None
        self._held.clear()

    def _open(self) -> int:
        if self._file is None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._file = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        return self._file
