"""The host of one machine, whose workers evaluate jobs: child processes, started on demand and watched for crashes.

Workers are driven by JSON messages. Values never pass through here: workers read and write the store. Before a job is
evaluated, its host compares what the key stands for with what it has itself, and looks for the result in the store.
"""

import json
import os
import signal
import socket
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, NamedTuple

from hairpipe import child
from hairpipe.engine.code import CodeReader, version
from hairpipe.engine.hosts.offer import Offer, code_difference
from hairpipe.engine.plan.key import differing_versions
from hairpipe.engine.store.digest import Parts
from hairpipe.engine.store.fingerprint import fingerprint
from hairpipe.engine.store.lease import Leases, forget_failure, note_failure
from hairpipe.engine.store.store import Store
from hairpipe.engine.worker.machine_code import claim_kernels, kernels_environment, kernels_parent
from hairpipe.engine.worker.threading_layer import THREADS, choose_layer
from hairpipe.errors import BadInput
from hairpipe.plain_file import Stamp, stamp_of
from hairpipe.processor import class_settings, processor_class

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
        self.process.kill()
        self.process.wait()
        self.connection.close()

    @property
    def fate(self) -> str:
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
    own = {name: value for name, value in child.environment().items() if name not in OF_THE_SHELL}
    return own | class_settings() | choose_layer().settings | single | {THREADS: str(threads)} | kernels


Reply = dict[str, Any]
"""Answer to a job, as plain values: its `key`, the `machine`, `held`, the objects that only its worker has, and one of

record   fields of its record, which is in the store; with `found`, it was there before
leased   another process evaluates it, or has the state that it starts from in memory
lost     name of an object that is missing
failure  kind, message and traceback, as in `Failure`
"""


@dataclass(frozen=True)
class Job:
    """An evaluation, as plain values: its JSON may go to another machine.

    module   of the node type, by which a host digests its code
    parts    of the key; inputs are named by their digests
    settings of the node, with absolute paths of files
    files    digests of those files by path
    outputs  names of the outputs
    spared   output that a stored result may lack: the state of a scan, which may have been thinned
    wide     whether it runs on all threads of a machine
    avoid    machines that have failed at it
    fleeting output that may stay in memory, unwritten: the state of a scan that only its next frame takes
    """

    key: str
    node: str
    frame: int | None
    type: str
    module: str
    parts: Parts
    settings: dict[str, Any]
    time: dict[str, Any]
    files: dict[str, str]
    outputs: tuple[str, ...]
    spared: str | None
    wide: bool
    avoid: tuple[str, ...] = ()
    fleeting: str | None = None


class Slots(NamedTuple):
    """Numbers of jobs that can begin now: wide ones take all threads of a machine, narrow ones run next to others."""

    wide: int
    narrow: int


MEMORY = 256 << 20
"""Memory in which a worker keeps values it may need again [bytes]."""


class Host:
    """Evaluates the jobs of one run on this machine.

    machine   its name in replies
    threads   of a wide job
    reader    of the code on this machine
    codes     digests of the code behind modules on this machine, as far as known
    spare     idle workers of earlier runs: taken before one is started, given back at the end; None: all end
    kernels   environment that names the compiled kernels; None before it is needed
    warnings  for the user
    """

    def __init__(
        self,
        offer: Offer,
        machine: str,
        threads: int,
        reader: CodeReader,
        codes: dict[str, str] | None = None,
        spare: list[Member] | None = None,
    ) -> None:
        self.machine, self.threads = machine, threads
        self.store = Store(Path(offer.store))
        self.leases = Leases(self.store)
        self.hello: dict[str, Any] = {"store": offer.store, "folder": offer.folder}
        self.hello |= {"trusted": offer.trusted, "memory": MEMORY, "processor_class": processor_class()}
        self.hello |= {"sources": reader.stamps}
        self.modules = sorted(set(offer.modules))
        self.reader, self.spare = reader, spare
        self.kernels: dict[str, str] | None = None
        damaged = self.leases.sweep()
        message = f"{len(damaged)} damaged leases were removed"
        self.warnings = [f"{message}, the first {damaged[0]}"] if damaged else []
        self.members: list[Member] = []
        self._codes = codes or {}
        self._stamps: dict[tuple[str, str], Stamp] = {}
        self._passing: tempfile.TemporaryDirectory[str] | None = None

    @property
    def busy(self) -> list[Member]:
        return [member for member in self.members if member.key is not None]

    def begin(self, job: Job) -> Reply | Member:
        """Give a job to a worker, or reply where this machine must not evaluate it, or nothing is left to evaluate."""
        reply: Reply = {"key": job.key, "machine": self.machine}
        try:
            self._check_code(job)
            stamps = {path: self._stamp(path, digest) for path, digest in job.files.items()}
        except BadInput as error:
            return reply | {"failure": {"kind": "mismatch", "message": str(error), "traceback": ""}}
        previous = job.parts["inputs"].get("previous")
        idle = [member for member in self.members if member.wide == job.wide and member.key is None]
        holder = next((member for member in idle if previous in member.held), None)
        if (holder is None and self._is_held(previous)) or not self.leases.acquire(job.key):
            return reply | {"leased": True}
        self.store.refresh(job.key)
        record = self.store.find(job.key, without=job.spared)
        if record is not None and record.outputs.keys() == set(job.outputs):
            self.leases.release(job.key)
            return reply | {"record": asdict(record), "found": True}
        forget_failure(self.store, job.key)
        member = holder or next(iter(idle), None) or self._engage(job.wide)
        member.key = job.key
        with suppress(OSError):  # a worker that is dead already is noticed by `reply_of`
            member.connection.send_bytes(json.dumps(vars(job) | {"files": stamps}).encode())
        return member

    def reply_of(self, member: Member) -> Reply:
        """Receive the reply of a worker; that of one that died is a failure."""
        key = member.key
        assert key is not None
        try:
            reply = json.loads(member.connection.recv_bytes())
            member.key = None
            member.held = frozenset(reply["held"])
        except (EOFError, OSError):
            self.members.remove(member)
            reply = {"failure": {"kind": "crash", "message": member.fate, "traceback": ""}}
            self.leases.sweep()
        if "failure" in reply:
            note_failure(self.store, key, reply["failure"]["message"])
        self.leases.release(key)
        return reply | {"key": key, "machine": self.machine}

    def cancel(self, keys: set[str]) -> None:
        """Kill the workers that evaluate jobs of these keys: they are evaluated again later."""
        for member in [member for member in self.busy if member.key in keys]:
            member.end()
            self.members.remove(member)
            self.leases.release(member.key or "")
        self.leases.sweep()

    def close(self) -> None:
        """Give back all leases, and kill all workers but spare ones: stored results stay, with the states they need."""
        for member in self.members:
            if member.key is None and member.held:
                member.save()
            if self.spare is None or self._passing or member.key is not None:
                member.end()
            else:
                self.spare.append(member)
        self.members.clear()
        self.leases.close()
        self.leases.sweep()
        if self._passing is not None:
            self._passing.cleanup()

    def _is_held(self, state: str | None) -> bool:
        return state is not None and not self.store.has(state) and self.leases.is_in_memory(state)

    def _check_code(self, job: Job) -> None:
        if job.module not in self._codes:
            code = self.reader.code_of(job.module)
            if code.digest != job.parts["code"]:
                raise code_difference(self.machine, job.type, code, self.store.recall(job.parts["code"]))
            self._codes[job.module] = code.digest
        for name, theirs in differing_versions(job.parts["settings"]).items():
            what = f"{self.machine} has other code of '{job.type}': {name} {version(name)} in place of {theirs}"
            raise BadInput(what, right="install the same versions there, and retry")

    def _stamp(self, path: str, digest: str) -> Stamp:
        """Stamp an input file that has this digest; BadInput where it has another one."""
        if (path, digest) not in self._stamps:
            try:
                stamp = stamp_of(path)
                found = fingerprint(Path(path), self.store)
            except OSError as error:
                raise BadInput(f"cannot be read on {self.machine}: {error.strerror}", where=path) from None
            if found != digest:
                raise BadInput("changed while it was read", where=path, right="run again when it is complete")
            self._stamps[path, digest] = stamp
        return self._stamps[path, digest]

    def _find_kernels(self) -> dict[str, str]:
        """Find the folder for kernels, and which are current; BadInput where others may write to it."""
        try:
            parent = claim_kernels(kernels_parent())
        except OSError as error:
            self._passing = tempfile.TemporaryDirectory(prefix="hairpipe-")
            self.warnings.append(f"kernels are compiled for this run alone: {error} (NUMBA_CACHE_DIR=FOLDER)")
            parent = Path(self._passing.name)
        return kernels_environment(parent, self.reader, self.modules)

    def _engage(self, wide: bool) -> Member:
        """Take a spare worker, or start one; spare ones of this width that do not serve are killed.

        The new one is told of their sources, too: runs whose nodes differ, in turn, would else each end the other's.
        """
        self.kernels = self.kernels or self._find_kernels()
        surroundings = environment(self.threads if wide else 1, self.kernels)
        spare = self.spare or []
        sources: dict[str, Stamp] = {}
        for member in [member for member in spare if member.wide == wide]:
            spare.remove(member)
            if member.serves(self.hello, surroundings):
                self.members.append(member)
                return member
            sources |= member.hello["sources"]
            member.end()
        same = {path: stamp for path, stamp in sources.items() if stamp_of(path) == stamp}
        self.members.append(start(wide, surroundings, self.hello | {"sources": same | self.reader.stamps}))
        return self.members[-1]


MACHINE = "this machine"


class LocalEngine:
    """Evaluates jobs in the workers of this machine; `DaskEngine` has the same methods.

    most      numbers of jobs at a time; by default a wide one, and as many narrow ones as a wide one has threads
    machines  names of those that take jobs
    """

    def __init__(self, host: Host, most: Slots | None = None) -> None:
        self.host, self.most = host, most or Slots(1, host.threads)
        self.machines = {host.machine}
        self.warnings = host.warnings
        self._at_once: list[Reply] = []

    def slots(self) -> Slots:
        wide = sum(member.wide for member in self.host.busy)
        return Slots(self.most.wide - wide, self.most.narrow - len(self.host.busy) + wide)

    def submit(self, job: Job) -> None:
        begun = self.host.begin(job)
        if not isinstance(begun, Member):
            self._at_once.append(begun)

    def replies(self, timeout: float | None) -> Iterator[Reply]:
        """Wait for replies, at most for a time [s]; that of a worker that died is a failure."""
        if self._at_once:
            yield self._at_once.pop()
            return
        ready = wait([member.connection for member in self.host.busy], timeout)
        for member in [member for member in self.host.busy if member.connection in ready]:
            yield self.host.reply_of(member)

    def leave_out(self, machine: str) -> None:
        self.machines.discard(machine)

    def cancel(self, keys: Iterable[str]) -> None:
        self.host.cancel(set(keys))

    def close(self) -> None:
        self.host.close()
