"""Renewal of the files that a process holds: their modification stamps change as long as it lives.

Watchers ask only whether a stamp has changed: no clock is compared with that of another machine.
"""

import os
import signal
import threading
from contextlib import suppress

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
