"""The hosts of a process that works for coordinators on other machines: text in, text out, any number of threads."""

import atexit
import json
import threading
import time
from contextlib import suppress
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.graph.engine.host import Host
from hairpipe.graph.engine.member import Member
from hairpipe.graph.engine.offer import Offer, accept
from hairpipe.graph.engine.protocol import Job, Reply
from hairpipe.graph.key.code import CodeReader
from hairpipe.graph.store.store import Store

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
