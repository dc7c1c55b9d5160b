"""Leases of keys: one evaluation of an action at a time, among all processes and machines that share a store.

A lease is a file that is created exclusively and renewed by its holder. It has expired where its holder is known to
have ended, or where its stamp has not changed for a time by the clock of the watcher. It is taken over by the exclusive
creation of its successor:

    lease/<key>          of the first holder, whose name is in the file
    lease/<key>.<name>   of the holder that took over from the one of this name
    lease/<file>.0       of the holder that took over a file without a name, see below

A name is used once, so that of any number of processes that see the same lease expire one creates the successor. A
holder that gives a lease back creates that file first: from then on nobody can take over. No lock is used, since many
network file systems grant a lock to each machine. A slow holder whose lease was taken over finishes: at worst an action
is evaluated twice, with the same result.

The name is written at once, by one call, after the file is created. A file that stays empty is of a holder that ended
in between, or whose disk is full. Anything else without a name is damaged, and no lease: a link, a folder, other bytes.

Notes of failed evaluations in a store, for whoever plans or watches; no run depends on them.

The note of a key is made on the machine where its evaluation failed, and removed when another one starts.
"""

import json
import os
import socket
import stat
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from hairpipe.engine.node.messages import one_line
from hairpipe.engine.store.atomic import discard, is_at, reopening
from hairpipe.engine.store.digest import DIGEST_BYTES, digest, is_key, parsed
from hairpipe.engine.store.holder import FORM, has_ended, make_name, renewal
from hairpipe.engine.store.store import Store

EXPIRY = 60.0
"""Time without a renewal after which a lease has expired; six renewals [s]."""
EMPTY = 5.0
"""The same of a file without bytes [s]."""
KEY = 2 * DIGEST_BYTES
"""Length of a key, with which the name of a lease file begins."""
READABLE = 0o644
"""Permissions of a lease file: other users of the store read who holds it, whatever the umask."""
LONGEST = 1 << 12
"""Of the text in a lease file [bytes]."""


class Lease(NamedTuple):
    """A lease file as found."""

    path: Path
    name: str  # of its holder; empty where none can be read
    host: str  # of its holder, for people
    stamp: int  # changes when the lease is renewed
    patience: float  # time without a renewal after which it has expired [s]; 0 where it is damaged

    @property
    def successor(self) -> Path:
        """Path of the lease of whoever takes over."""
        return self.path.with_name(f"{self.path.name}.0" if not self.name else f"{self.path.name[:KEY]}.{self.name}")


class Held(NamedTuple):
    """A lease of this process: its open file, its name, and the expired leases that it follows, first one first."""

    handle: int
    path: Path
    name: str
    before: tuple[Lease, ...]


class Leases:
    """The leases that a process holds, and those that it watches.

    clock  of the watcher [s]
    """

    def __init__(self, store: Store, clock: Callable[[], float] = time.monotonic) -> None:
        self._store = store
        self._folder = store.root / "lease"
        self._clock = clock
        self._held: dict[str, Held] = {}
        self._seen: dict[tuple[Path, str], tuple[int, float]] = {}

    def acquire(self, key: str) -> bool:
        """Acquire the lease of a key without waiting; False where it is held. OSError where none can be made."""
        if key in self._held:
            return False
        before: list[Lease] = []
        path = self._folder / key
        name = make_name()
        while (handle := self._create(path, name)) is None:
            found = read_lease(path)
            if found is None or not self._has_expired(found):
                return False
            before.append(found)
            path = found.successor
        if any(self._name_at(lease.path) != lease.name for lease in before):  # given back since it was seen
            os.close(handle)
            path.unlink(missing_ok=True)
            return False
        renewal.add(handle)
        self._held[key] = Held(handle, path, name, tuple(before))
        return True

    def release(self, key: str) -> None:
        """Give the lease of a key back; nothing is changed where another process has taken over."""
        held = self._held.pop(key, None)
        if held is None:
            return
        renewal.discard(held.handle)
        closed = self._folder / f"{key}.{held.name}"
        with suppress(OSError):
            end = self._create(closed, make_name())
            if end is not None:
                os.close(end)
                own = is_at(held.handle, held.path)
                for path in [*(lease.path for lease in held.before), held.path] if own else []:
                    discard(path)
                closed.unlink(missing_ok=True)
        os.close(held.handle)

    def is_in_memory(self, name: str) -> bool:
        """Whether a process holds the lease of an object: it alone has the object, in memory."""
        return self.holder(lease_of(name)) is not None

    def holder(self, key: str) -> Lease | None:
        """Find the lease of whoever evaluates a key; None where nobody is known to. Nothing is written."""
        lease = read_lease(self._folder / key)
        while lease is not None and (successor := read_lease(lease.successor)) is not None:
            lease = successor
        return None if lease is None or self._has_expired(lease) else lease

    def holders(self, keys: Iterable[str]) -> dict[str, Lease]:
        """Find the leases of whoever evaluates some keys, few of many: the folder is listed once."""
        listed: set[str] = set()
        with suppress(FileNotFoundError):
            listed = {path.name[:KEY] for path in self._folder.iterdir()}
        found = {key: self.holder(key) for key in sorted(listed.intersection(keys))}
        return {key: lease for key, lease in found.items() if lease is not None}

    def sweep(self) -> list[Path]:
        """Give back the leases of processes of this machine that have ended; others are removed after a day.

        Returns the damaged ones, which are removed.
        """
        damaged: list[Path] = []
        with suppress(OSError):  # no folder, or one that cannot be written to
            for path in sorted(self._folder.iterdir()):
                key = path.name[:KEY]
                lease = read_lease(path) if is_key(key) else None
                if lease is None or (lease.patience and not has_ended(lease.name)):
                    continue
                if not lease.patience:
                    damaged.append(path)
                if path.name != key and not os.path.lexists(self._folder / key):
                    discard(path)  # its holder could not remove it after the lease itself
                elif self.acquire(key):
                    self.release(key)
        return damaged

    def close(self) -> None:
        for key in list(self._held):
            self.release(key)

    def _create(self, path: Path, name: str) -> int | None:
        """Create a lease file; its open file, or None where there is one."""
        try:
            handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        except FileExistsError:
            return None
        except (FileNotFoundError, NotADirectoryError):
            return self._create(self._store.room(path), name)
        with suppress(OSError):  # on a full disk it has no name
            os.fchmod(handle, READABLE)
            os.write(handle, json.dumps({"holder": name, "host": socket.gethostname()}).encode())
        return handle

    def _has_expired(self, lease: Lease) -> bool:
        """Whether a lease has expired, as far as this process knows."""
        if has_ended(lease.name) or not lease.patience:
            return True
        now = self._clock()
        stamp, since = self._seen.get((lease.path, lease.name), (None, now))
        if stamp != lease.stamp:
            since = now
        self._seen[lease.path, lease.name] = lease.stamp, since
        return now - since >= lease.patience

    def _name_at(self, path: Path) -> str | None:
        found = read_lease(path)
        return None if found is None else found.name


def lease_of(name: str) -> str:
    """Return the key of the lease of an object: its digest."""
    return name.partition(".")[0]


def read_lease(path: Path) -> Lease | None:
    """Read a lease file; None where there is none, and without a name where no holder can be read.

    It is opened, since a client of a network file system asks the server for the stamp then.
    """
    text = None
    try:
        if not stat.S_ISREG(path.lstat().st_mode):
            return Lease(path, "", "", 0, 0.0)
        with suppress(OSError):  # that of another user may not be readable
            text = _beginning(path)
        stamp = path.lstat().st_mtime_ns
    except OSError:
        return None
    with suppress(ValueError, TypeError, KeyError):
        fields = parsed(text or "null")
        name, host = str(fields["holder"]), str(fields["host"])
        if FORM.fullmatch(name):
            return Lease(path, name, host, stamp, EXPIRY)
    return Lease(path, "", "", stamp, EXPIRY if text is None else 0.0 if text else EMPTY)


@reopening
def _beginning(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(LONGEST)


class FailureNote(NamedTuple):
    """The machine where an evaluation failed, and its message."""

    host: str
    message: str

    def __str__(self) -> str:
        """One line: `failed on render-7: ValueError: no faces`."""
        return one_line(f"failed on {self.host}: {self.message}")


def note_failure(store: Store, key: str, message: str) -> None:
    """Note that the evaluation of a key failed on this machine."""
    store.note(digest("failure", key), json.dumps([socket.gethostname(), message]))


def recall_failure(store: Store, key: str) -> FailureNote | None:
    """Read the note of a key; None where its evaluation has not failed, or another one has started since.

    Whoever may write to the store may have written something else there: None for that, too.
    """
    text = store.recall(digest("failure", key))
    with suppress(ValueError):
        match parsed(text or "null"):
            case [str(host), str(message)]:
                return FailureNote(host, message)
    return None


def forget_failure(store: Store, key: str) -> None:
    """Remove the note of a key."""
    store.forget(digest("failure", key))
