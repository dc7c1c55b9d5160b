"""The coordinator's side of the worker processes: started on demand, driven by JSON messages, watched for crashes.

Values never pass through here: workers read and write the store.
"""

import json
import os
import signal
import socket
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, Literal

from hairpipe import child
from hairpipe.graph.key.code import CodeReader
from hairpipe.graph.plan.tasks import Task
from hairpipe.graph.store.fingerprint import is_changed
from hairpipe.graph.worker.machine_code import claim_kernels, kernels_environment, kernels_parent
from hairpipe.graph.worker.threading_layer import choose_layer
from hairpipe.processor import class_settings, processor_class

WorkerKind = Literal["serial", "parallel"]
"""A serial worker computes on one thread, next to others; the parallel one uses all threads for the critical path."""

SERIAL_NICENESS = 10
"""Niceness of serial workers: threads of the parallel one wait for each other, so one delayed thread delays all."""
BOOT = "from hairpipe.graph.worker.worker import main; main({})"
MEMORY = 256 << 20
"""Memory in which a worker keeps values it may need again [bytes]."""


@dataclass(eq=False)
class Member:
    """A worker process, the first message and the environment that it was given, and the task that it evaluates."""

    kind: WorkerKind
    process: "subprocess.Popen[bytes]"
    connection: Connection
    hello: dict[str, Any]
    environment: dict[str, str]
    task: Task | None = None

    def serves(self, hello: dict[str, Any], environment: dict[str, str]) -> bool:
        """Whether it is what a worker started now would be: it may have imported any source it was told of."""
        if self.process.poll() is not None or self.environment != environment:
            return False
        told = self.hello["sources"]
        sources = hello["sources"]
        alike = self.hello | {"sources": sources} == hello
        return alike and all(told.get(path) == stamp for path, stamp in sources.items())

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


class Pool:
    """Up to `jobs` serial workers, and a parallel one with `jobs` threads.

    hello     first message to each worker: store, codec, folder of node types, class of the processor, stamps of the
              sources behind the keys
    nodes     modules of the node types that they will load
    reader    of the sources
    kernels   environment that names the compiled kernels; None before it is needed
    spare     idle workers of earlier pools: taken before one is started, given back at the end; None: all end
    warnings  for the user
    """

    def __init__(
        self,
        store: Path,
        codec: str,
        folder: Path,
        jobs: int,
        nodes: Iterable[str],
        reader: CodeReader,
        spare: list[Member] | None = None,
    ) -> None:
        self.hello = {"store": str(store), "codec": codec, "folder": str(folder), "memory": MEMORY}
        self.hello["processor_class"] = processor_class()
        self.hello["sources"] = reader.stamps
        self.jobs = jobs
        self.nodes = sorted(set(nodes))
        self.reader = reader
        self.spare = spare
        self.kernels: dict[str, str] | None = None
        self.warnings: list[str] = []
        self._passing: tempfile.TemporaryDirectory[str] | None = None
        self.members: list[Member] = []

    @property
    def busy(self) -> list[Member]:
        """Workers that are evaluating a task."""
        return [member for member in self.members if member.task is not None]

    def free(self, kind: WorkerKind) -> bool:
        """Whether a worker of this kind is idle or may be started."""
        own = [member for member in self.members if member.kind == kind]
        return any(m.task is None for m in own) or len(own) < (self.jobs if kind == "serial" else 1)

    def send(self, kind: WorkerKind, task: Task, job: dict[str, Any]) -> None:
        """Give a job to a free worker of this kind."""
        idle = (m for m in self.members if m.kind == kind and m.task is None)
        member = next(idle, None) or self._engage(kind)
        member.task = task
        with suppress(OSError):  # a worker that is dead already is noticed by `receive`
            member.connection.send_bytes(json.dumps(job).encode())

    def receive(self, timeout: float | None) -> Iterator[tuple[Task, dict[str, Any]]]:
        """Wait for replies; for a worker that died, the reply is a failure."""
        ready = wait([member.connection for member in self.busy], timeout)
        for member in [member for member in self.busy if member.connection in ready]:
            task = member.task
            member.task = None
            assert task is not None
            try:
                reply = json.loads(member.connection.recv_bytes())
            except (EOFError, OSError):
                self.members.remove(member)
                reply = {"failure": {"kind": "crash", "message": member.fate, "traceback": ""}}
            yield task, reply

    def close(self) -> None:
        """Kill all workers but spare ones: stored results stay, tasks in progress are evaluated again later."""
        for member in self.members:
            if self.spare is None or self._passing or member.task is not None:
                member.end()
            else:
                self.spare.append(member)
        self.members.clear()
        if self._passing is not None:
            self._passing.cleanup()

    def _find_kernels(self) -> dict[str, str]:
        """Find the folder for kernels, and which are current; BadInput where others may write to it."""
        try:
            parent = claim_kernels(kernels_parent())
        except OSError as error:
            self._passing = tempfile.TemporaryDirectory(prefix="hairpipe-")
            self.warnings.append(f"kernels are compiled for this run alone: {error} (NUMBA_CACHE_DIR=FOLDER)")
            parent = Path(self._passing.name)
        if warning := choose_layer().warning:
            self.warnings.append(warning)
        return kernels_environment(parent, self.reader, self.nodes)

    def _engage(self, kind: WorkerKind) -> Member:
        """Take a spare worker, or start one; spare ones of this kind that do not serve are killed.

        The new one is told of their sources, too: runs whose nodes differ, in turn, would else each end the other's.
        """
        self.kernels = self.kernels or self._find_kernels()
        surroundings = environment(self.jobs if kind == "parallel" else 1, self.kernels)
        spare = self.spare or []
        sources: dict[str, list[int]] = {}
        for member in [member for member in spare if member.kind == kind]:
            spare.remove(member)
            if member.serves(self.hello, surroundings):
                self.members.append(member)
                return member
            sources |= member.hello["sources"]
            member.end()
        same = {path: stamp for path, stamp in sources.items() if not is_changed(path, stamp)}
        return self._start(kind, surroundings, same | self.reader.stamps)

    def _start(self, kind: WorkerKind, surroundings: dict[str, str], sources: dict[str, list[int]]) -> Member:
        """Start a worker; its standard output is redirected to standard error, where it mixes with no result."""
        ours, theirs = socket.socketpair()
        with theirs, interrupts_blocked():
            process = subprocess.Popen(
                child.command(BOOT.format(theirs.fileno())),
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=2,
                env=surroundings,
            )
        if kind == "serial":
            with suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, process.pid, SERIAL_NICENESS)
        hello = self.hello | {"sources": sources}
        member = Member(kind, process, Connection(ours.detach()), hello, surroundings)
        self.members.append(member)
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
    return child.environment() | class_settings() | choose_layer().settings | single | kernels
