"""A worker process of a host: started on demand, driven by JSON messages, watched for crashes.

Values never pass through here: workers read and write the store.
"""

import json
import os
import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from hairpipe import child
from hairpipe.engine.worker.threading_layer import choose_layer
from hairpipe.processor import class_settings

NARROW_NICENESS = 10
"""Niceness of narrow workers: threads of the wide one wait for each other, so one delayed thread delays all."""
OF_THE_SHELL = {"_", "OLDPWD", "PWD", "SHLVL"}
"""Variables that change from command to command, without effect on a worker."""
PATIENCE = 60.0
"""Time within which an idle worker must have written what it holds [s]."""
BOOT = "from hairpipe.engine.worker.worker import main; main({})"


@dataclass(eq=False)
class Member:
    """A worker process, its first message and environment, and the key of the job that it evaluates.

    held  names of the states that are only in its memory
    wide  whether it uses all threads, for the critical path; a narrow one runs next to others
    """

    wide: bool
    process: "subprocess.Popen[bytes]"
    connection: Connection
    hello: dict[str, Any]
    environment: dict[str, str]
    key: str | None = None
    held: frozenset[str] = frozenset()

    def serves(self, hello: dict[str, Any], environment: dict[str, str]) -> bool:
        """Whether it is what a worker started now would be: it may have imported any source it was told of."""
        if self.process.poll() is not None or self.environment != environment:
            return False
        reported = self.hello["sources"]
        sources = hello["sources"]
        alike = self.hello | {"sources": sources} == hello
        return alike and all(reported.get(path) == stamp for path, stamp in sources.items())

    def save(self) -> None:
        """Have an idle process write the states that are only in its memory."""
        with suppress(EOFError, OSError):
            self.connection.send_bytes(b"null")
            if self.connection.poll(PATIENCE):
                self.held = frozenset(json.loads(self.connection.recv_bytes())["held"])

    def end(self) -> None:
        """Kill the process."""
        self.process.kill()
        self.process.wait()
        self.connection.close()

    @property
    def fate(self) -> str:
        """Say how the process ended."""
        code = self.process.wait()
        if code >= 0:
            return f"the worker process ended with exit code {code}"
        hint = ", possibly out of memory" if -code == signal.SIGKILL else ""
        return f"the worker process was ended by {signal.Signals(-code).name}{hint}"


def start(wide: bool, environment: dict[str, str], hello: dict[str, Any]) -> Member:
    """Start a worker; its standard output is redirected to standard error, where it mixes with no result.

    hello  first message: store, folder of node types and what is trusted in it, memory, class of the processor,
           stamps of the sources behind the keys
    """
    ours, theirs = socket.socketpair()
    with theirs, interrupts_blocked():
        process = subprocess.Popen(
            child.command(BOOT.format(theirs.fileno())),
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=2,
            env=environment,
        )
    if not wide:
        with suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, process.pid, NARROW_NICENESS)
    member = Member(wide, process, Connection(ours.detach()), hello, environment)
    with suppress(OSError):
        member.connection.send_bytes(json.dumps(hello).encode())
    return member


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """Block SIGINT, which goes to the whole process group, in processes started meanwhile: the coordinator handles it.

    They never receive it, not even before their first line; this process receives it afterwards.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def environment(threads: int, kernels: dict[str, str]) -> dict[str, str]:
    """Environment of a worker: numba on these threads, linear algebra on one, since its sums depend on their number.

    All of it is kept to the class of the processor, whose results are equal to the bit.

    kernels  see `kernels_environment`
    """
    single = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1")
    single |= {"NUMBA_NUM_THREADS": str(threads)}
    own = {name: value for name, value in child.environment().items() if name not in OF_THE_SHELL}
    return own | class_settings() | choose_layer().settings | single | kernels
