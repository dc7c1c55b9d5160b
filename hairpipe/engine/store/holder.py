"""The process that holds a lease or a temporary file, named by machine, number and start.

A process of this machine, boot and process name space can be looked up, and has ended or not. Nothing is known of
others.

Renewal of the files that a process holds: their modification stamps change as long as it lives.

Watchers ask only whether a stamp has changed: no clock is compared with that of another machine.
"""

import os
import re
import secrets
import signal
import socket
import threading
import uuid
from contextlib import suppress
from functools import cache
from pathlib import Path

from hairpipe.engine.store.digest import digest_bytes

FORM = re.compile(r"([0-9a-f]{12})-(\d{1,9})-(\d{1,20})-[0-9a-f]{16}")
MACHINE_DIGITS = 12


def make_name() -> str:
    """Make a unique name of something that this process holds."""
    pid = os.getpid()
    return f"{machine()}-{pid}-{_start_here(pid)}-{secrets.token_hex(8)}"


def has_ended(name: str) -> bool:
    """Whether the process that made a name is known to have ended; False for one of another machine."""
    found = FORM.fullmatch(name)
    if found is None or found[1] != machine():
        return False
    pid = int(found[2])
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except OSError:  # it belongs to another user
        pass
    return start_of(pid) not in (None, found[3])


@cache
def machine() -> str:
    """Name this machine since it was booted: numbers of processes mean the same to all that have the same name.

    Containers on one kernel have numbers of their own.
    """
    boot = numbers = ""
    with suppress(OSError):
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii")
        numbers = str(Path("/proc/self/ns/pid").stat().st_ino)
    name = f"{socket.gethostname()} {boot or uuid.getnode()} {numbers}"
    return digest_bytes("machine", name.encode())[:MACHINE_DIGITS]


@cache
def _start_here(pid: int) -> str:
    """Return when this process began; a fork has another number."""
    return start_of(pid) or "0"


def start_of(pid: int) -> str | None:
    """Return when a process began, as Linux counts; empty where it has ended and was not collected, None if unknown."""
    try:
        line = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace")
    except OSError:
        return None
    state, *fields = line.rpartition(")")[2].split()
    return "" if state in "ZXx" else fields[18]


PERIOD = 10.0
"""Time between two renewals [s]."""


class Renewal:
    """A thread that renews open files, from the first one that is added on."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._handles: set[int] = set()
        self._thread: threading.Thread | None = None

    def add(self, handle: int) -> None:
        """Renew an open file from now on."""
        with self._lock:
            self._handles.add(handle)
            if self._thread is None:
                self._start()

    def discard(self, handle: int) -> None:
        """Leave a file alone from now on; it may be closed then."""
        with self._lock:
            self._handles.discard(handle)

    def renew(self) -> None:
        """Give all files a new stamp; one that cannot be renewed expires."""
        with self._lock:  # a number that was closed may be that of another file
            for handle in self._handles:
                with suppress(OSError):
                    os.utime(handle)

    def _start(self) -> None:
        """Start the thread, which receives no signal: Ctrl-C is handled, and blocked, in the main one."""
        before = signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        try:
            self._thread = threading.Thread(target=self._serve, name="renewal", daemon=True)
            self._thread.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def _serve(self) -> None:
        pause = threading.Event()
        while not pause.wait(PERIOD):
            self.renew()


renewal = Renewal()
"""That of this process; a fork holds nothing."""
os.register_at_fork(after_in_child=renewal.__init__)  # the thread is not forked, and the lock may be held
