"""Simulated processes: coordinators whose workers run in this very process, and which can be killed at any call.

A killed process makes no further call: what Python still cleans up in its name does not reach the disk.
"""

import itertools
import json
import os
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

from hairpipe.engine.hosts import host
from hairpipe.engine.hosts import host as local_engine
from hairpipe.engine.hosts.host import Member
from hairpipe.engine.run import scheduler
from hairpipe.engine.store import atomic, lease
from hairpipe.engine.store.holder import Renewal
from hairpipe.engine.worker import machine_code, worker
from hairpipe.engine.worker.worker import Worker

MACHINE = "0" * 12
stamp = os.utime
"""The function itself, whatever replaces it later."""


class Killed(BaseException):
    """The process was killed: nothing catches this."""


class Processes:
    """The simulated processes of one machine, by number; each runs in a thread.

    dead  numbers of those that were killed, or have ended
    """

    def __init__(self) -> None:
        self.dead: set[int] = set()
        self._numbers = itertools.count(1)
        self._names = itertools.count(1)
        self._running = threading.local()
        self._time = 0
        self._began = time.time_ns()
        self._held: dict[int, int] = {}

    @property
    def current(self) -> int:
        """Number of the process that this thread runs."""
        return self._running.number

    def begin(self) -> None:
        """Begin a process in this thread."""
        self._running.number = next(self._numbers)

    def end(self) -> None:
        """End the current process: its files are closed, and it makes no further call."""
        self.dead.add(self.current)
        self._held = {handle: number for handle, number in self._held.items() if number not in self.dead}

    def kill(self) -> None:
        """Kill the current process."""
        self.end()
        raise Killed

    def check(self) -> None:
        """Stop the current process again where it was killed."""
        if self.current in self.dead:
            raise Killed

    def make_name(self) -> str:
        """Name something that the current process holds, as `holder.make_name`."""
        return f"{MACHINE}-{self.current}-0-{next(self._names):016x}"

    def has_ended(self, name: str) -> bool:
        """Whether the process of a name has ended, as `holder.has_ended`."""
        fields = name.split("-")
        return len(fields) == 4 and int(fields[1]) in self.dead

    def hold(self, handle: int) -> None:
        """Renew an open file of the current process from now on, as `Renewal.add`."""
        self._held[handle] = self.current

    def drop(self, handle: int) -> None:
        """Leave a file alone from now on, as `Renewal.discard`."""
        self._held.pop(handle, None)

    def clock(self) -> float:
        """Read the time [s], which passes by being read: files that are held have a new stamp then."""
        self._time += 1
        for handle in self._held:
            stamp(handle, ns=(self._began + self._time, self._began + self._time))
        return float(self._time)


class Loop:
    """The connection to a worker in this process, which evaluates a job when it is sent."""

    def __init__(self) -> None:
        self._worker: Worker | None = None
        self._replies: list[bytes] = []
        self._is_broken = False

    def send_bytes(self, data: bytes) -> None:
        """Receive the first message, or a job."""
        message = json.loads(data)
        try:
            if self._worker is None:
                self._worker = Worker(message, lambda: False)
                return
            reply = self._worker.reply(message) if message else self._worker.save()
            self._replies.append(json.dumps(reply).encode())
        except OSError:  # a worker ends then
            self._is_broken = True

    def recv_bytes(self) -> bytes:
        """Return the reply; EOFError where the worker has ended."""
        if self._is_broken:
            raise EOFError
        return self._replies.pop(0)

    def poll(self, timeout: float | None = 0.0) -> bool:
        """Whether there is a reply, or an end."""
        return self._is_broken or bool(self._replies)

    def close(self) -> None:
        """Nothing is left to do."""


class Ended:
    """The process of a worker, as far as a host asks."""

    def poll(self) -> None:
        """It runs."""

    def wait(self) -> int:
        """Return its exit code."""
        return 1

    def kill(self) -> None:
        """Nothing is left to do."""


def start(wide: bool, environment: dict[str, str], hello: dict[str, Any]) -> Member:
    """Start a worker in this process, as `member.start`."""
    connection: Any = Loop()
    process: Any = Ended()
    connection.send_bytes(json.dumps(hello).encode())
    return Member(wide, process, connection, hello, environment)


def ready(connections: list[Any], timeout: float | None) -> list[Any]:
    """List connections with a reply, as `multiprocessing.connection.wait`: it is there once a job was sent."""
    return [connection for connection in connections if connection.poll()]


@contextmanager
def unrecorded() -> Iterator[list[str]]:
    """Record no warnings, as `recorded_warnings`, which is for one thread."""
    yield []


@contextmanager
def simulated(processes: Processes) -> Iterator[None]:
    """Let this process stand for simulated ones. Nothing sleeps."""
    with ExitStack() as stack:
        for module in (atomic, lease):
            stack.enter_context(patch.object(module, "make_name", processes.make_name))
            stack.enter_context(patch.object(module, "has_ended", processes.has_ended))
        stack.enter_context(patch.object(lease.Leases.__init__, "__defaults__", (processes.clock,)))
        stack.enter_context(patch.object(host, "start", start))
        stack.enter_context(patch.object(local_engine, "wait", ready))
        stack.enter_context(patch.object(scheduler, "POLL", 0.0))
        stack.enter_context(patch.object(time, "sleep", lambda seconds: None))
        stack.enter_context(patch.object(Renewal, "add", lambda renewal, handle: processes.hold(handle)))
        stack.enter_context(patch.object(Renewal, "discard", lambda renewal, handle: processes.drop(handle)))
        stack.enter_context(patch.object(worker, "recorded_warnings", unrecorded))
        stack.enter_context(patch.object(machine_code, "kernel_modules", lambda: iter(())))
        yield
