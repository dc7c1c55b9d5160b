"""The engine of a Dask cluster: a host in every Dask worker, whose child processes evaluate the jobs.

Dask carries texts. No node runs inside a Dask worker: a node may hold Python's lock, crash, or need an environment of
its own. The engine itself chooses the machine of a job, so that a scan stays where its state and its kernels are.
"""

import atexit
import json
import logging
import queue
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hairpipe.engine.code import CodeReader
from hairpipe.engine.hosts.host import Host, Job, Member, Reply, Slots
from hairpipe.engine.hosts.offer import Offer, accept
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput

if TYPE_CHECKING:
    from distributed import Client, Future


UNUSED = 60.0
"""Time after which the host of a run without jobs is closed [s]."""

_lock = threading.Lock()
_hosts: dict[str, tuple[Host, float]] = {}
"""Hosts by run, with the time of their last job."""
_spare: list[Member] = []


def evaluate(offer: str, job: str, machine: str, threads: int) -> str:
    """Evaluate a job for a run on this machine, and wait for its reply; all texts are JSON.

    machine  name of this one in the reply
    threads  of a wide job
    """
    given = Job(**json.loads(job))
    try:
        with _lock:
            host = _host_of(Offer(**json.loads(offer)), machine, threads)
            begun = host.begin(given)
    except (BadInput, OSError) as error:
        failure = {"kind": "mismatch", "message": f"{machine}: {error}", "traceback": ""}
        return json.dumps({"key": given.key, "machine": machine, "failure": failure})
    if not isinstance(begun, Member):
        return json.dumps(begun)
    with suppress(OSError):  # it was killed
        begun.connection.poll(None)
    with _lock:
        reply: Reply = host.reply_of(begun)
    return json.dumps(reply)


@atexit.register
def close() -> None:
    """Close all hosts: idle workers write the states that are only in their memory."""
    for host, _ in _hosts.values():
        host.close()


def kill(run: str, keys: list[str]) -> None:
    """Kill the workers that evaluate these jobs of a run; `evaluate` replies with a crash."""
    with _lock:
        for member in _hosts[run][0].busy if run in _hosts else ():
            if member.key in keys:
                member.process.kill()


def _host_of(offer: Offer, machine: str, threads: int) -> Host:
    """Find the host of a run, or make it after a comparison of this machine with the offer."""
    now = time.monotonic()
    for run, (host, used) in list(_hosts.items()):
        if run != offer.run and not host.busy and now - used > UNUSED:
            host.close()
            del _hosts[run]
    if offer.run not in _hosts:
        accept(offer, machine)
        reader = CodeReader(Store(Path(offer.store)).remember, Path(offer.folder))
        _hosts[offer.run] = Host(offer, machine, threads, reader, spare=_spare), now
    host = _hosts[offer.run][0]
    _hosts[offer.run] = host, now
    return host


WIDE, NARROW = "wide", "narrow"
"""Resources of a Dask worker: `--resources "wide=1 narrow=4"`."""
SILENCE = 60.0
"""Time without a heartbeat after which a machine is lost [s]."""
LOOK = 2.0
"""Time between two looks at the machines [s]."""
CONNECT = 20.0
"""Time within which the scheduler must answer [s]."""


class DaskEngine:
    """Evaluates jobs on the workers of a Dask scheduler; it connects when the first job is there.

    address   of the scheduler; BadInput where its port is open to everybody and that is not allowed
    offer     makes the offer of the run
    insecure  whether a connection without TLS is allowed
    """

    def __init__(self, address: str, offer: Callable[[], Offer], *, insecure: bool = False) -> None:
        if not address.startswith("tls://") and not insecure:
            right = "tls://HOST:PORT, or --insecure in a network where everybody is trusted"
            raise BadInput("whoever reaches this port can run code as you", where=address, right=right)
        self.address = address
        self.machines: set[str] = set()
        self.warnings: list[str] = []
        self._make_offer = offer
        self._client: Client | None = None
        self._is_silent = False
        self._resources: dict[str, dict[str, float]] = {}
        self._left_out: set[str] = set()
        self._seen: dict[str, tuple[Any, float]] = {}
        self._looked = 0.0
        self._jobs: dict[str, tuple[Job, str, Future]] = {}
        self._homes: dict[str, str] = {}
        self._count = 0
        self._done: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()

    def slots(self) -> Slots:
        self._look()
        return Slots(*(sum(max(0, n) for n in self._free(kind).values()) for kind in (WIDE, NARROW)))

    def submit(self, job: Job) -> None:
        """Begin a job: at its home, where the last frame of a scan was evaluated, else where most slots are free."""
        assert self._client is not None
        kind = WIDE if job.wide else NARROW
        machine = self._best_machine(job, kind)
        self._count += 1
        future = self._client.submit(
            evaluate,
            self._offer,
            json.dumps(vars(job)),
            machine,
            max(1, int(self._resources[machine].get(NARROW, 1))),
            key=f"node-{job.key}-{self._run}-{self._count}",
            workers=[machine],
            resources={kind: 1},
            retries=0,
            pure=False,
        )
        self._jobs[job.key] = job, machine, future
        future.add_done_callback(lambda done: self._done.put((job.key, done.key)))

    def replies(self, timeout: float | None) -> Iterator[Reply]:
        """Wait for replies; a machine that is lost or silent, and a lost scheduler, give failures."""
        end = None if timeout is None else time.monotonic() + timeout
        while self._jobs and (end is None or time.monotonic() < end):
            found = [job.key for job, machine, _ in self._jobs.values() if machine not in self._resources]
            try:
                left = LOOK if end is None else max(0.0, min(LOOK, end - time.monotonic()))
                key, name = self._done.get(timeout=0.0 if found else left)
                if key in self._jobs and self._jobs[key][2].key == name:  # else of a job that was given up
                    found.append(key)
            except queue.Empty:
                self._look()
            for key in dict.fromkeys(found):
                yield self._reply(key)
            if found:
                return
        if end is not None:
            time.sleep(max(0.0, end - time.monotonic()))

    def leave_out(self, machine: str) -> None:
        self._left_out.add(machine)
        self.machines.discard(machine)

    def cancel(self, keys: Iterable[str]) -> None:
        """Cancel jobs that have not begun, and kill the workers of the others."""
        running = [self._jobs.pop(key) for key in list(keys) if key in self._jobs]
        if self._client is None or self._client.status != "running" or not running:
            return
        machines = sorted({machine for _, machine, _ in running} & self._resources.keys())
        stopped = [job.key for job, _, _ in running]
        with suppress(OSError, TimeoutError):
            self._client.cancel([future for _, _, future in running])
            self._client.run(kill, self._run, stopped, workers=machines, on_error="ignore")

    def close(self) -> None:
        """Disconnect; results that are being computed are stored by their machines."""
        if self._client is not None:
            with suppress(OSError, TimeoutError):
                self._client.close(timeout=5)

    def _connect(self) -> "Client":
        """Connect to the scheduler; BadInput where none answers, or no worker offers slots."""
        try:
            from distributed import Client, Security
        except ImportError:
            raise BadInput("Dask is not installed", right="pip install 'hairpipe[dask]'") from None
        for name in ("distributed", "distributed.client"):
            logging.getLogger(name).setLevel(logging.CRITICAL)  # what is lost is reported here, in one line
        if self.address.startswith("tls:") and Security().get_connection_args("client")["ssl_context"] is None:
            raise BadInput("TLS needs a certificate", where=self.address, right="Dask's setting distributed.comm.tls")
        offer = self._make_offer()
        self._run, self._offer = offer.run, json.dumps(vars(offer))
        try:
            client = Client(self.address, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise BadInput(f"no Dask scheduler answers: {error}", where=self.address) from None
        with suppress(TimeoutError):  # workers may just have been started
            client.wait_for_workers(1, timeout=CONNECT)
        return client

    def _look(self) -> None:
        """Look at the machines, at most every two seconds: which are there, and which have been silent for too long."""
        now = time.monotonic()
        if self._client is None:
            self._client = self._connect()
        elif now - self._looked < LOOK:
            return
        self._looked = now
        found: dict[str, dict[str, float]] = {}
        for machine, worker in self._workers().items():
            stamp, since = self._seen.get(machine, (None, now))
            if worker["last_seen"] != stamp:
                since = now
            self._seen[machine] = worker["last_seen"], since
            if worker["resources"] and now - since < SILENCE:
                found[machine] = worker["resources"]
        first = not self._resources and not self._jobs
        self._resources = found
        self.machines = found.keys() - self._left_out
        if first and not found:
            right = f"dask worker {self.address} --nworkers 1 --nthreads 5 --resources 'wide=1 narrow=4'"
            raise BadInput("no Dask worker offers slots", where=self.address, right=right)

    def _workers(self) -> dict[str, Any]:
        """Ask the scheduler for its workers; none where it is lost, which one that does not answer stays."""
        client: Any = self._client  # whose types leave a scheduler, and a synchronous answer, open
        with suppress(OSError):
            if client.status == "running" and not self._is_silent:
                try:
                    return client.sync(client.scheduler.identity, callback_timeout=SILENCE)["workers"]
                except TimeoutError:
                    self._is_silent = True
        return {}

    def _free(self, kind: str) -> dict[str, int]:
        taken = Counter(machine for job, machine, _ in self._jobs.values() if job.wide == (kind == WIDE))
        return {name: int(self._resources[name].get(kind, 0)) - taken[name] for name in self.machines}

    def _best_machine(self, job: Job, kind: str) -> str:
        """Choose the machine of a job: its home, else that of the fewest scans, with the most free slots."""
        free = self._free(kind)
        able = [name for name in sorted(free) if free[name] > 0 and name not in job.avoid] or sorted(free)
        home = self._homes.get(job.node)
        if job.wide and home in able:
            return home
        homes = Counter(self._homes.values())
        return max(able, key=lambda name: (-homes[name], free[name]))

    def _reply(self, key: str) -> Reply:
        """Take the reply to a job; a failure where its machine or the scheduler is lost."""
        job, machine, future = self._jobs.pop(key)
        assert self._client is not None
        with suppress(OSError, TimeoutError, CancelledError):
            if future.status == "finished":
                reply: Reply = json.loads(future.result(timeout=CONNECT))
                if job.wide and "record" in reply:
                    self._homes[job.node] = machine
                return reply
        what = f"{machine} does not answer"
        if future.status == "error":
            what = f"{machine}: {future.exception()}"
        elif not self._workers():
            what = f"the Dask scheduler {self.address} is lost: run again"
            self.machines.clear()
            self._resources.clear()
        else:
            self._client.cancel([future])
        return {"key": key, "machine": machine, "failure": {"kind": "gone", "message": what, "traceback": ""}}
