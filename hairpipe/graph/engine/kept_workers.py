"""Workers that outlive a run: taken from the keeper of the user before the run, and given back after it."""

import os
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from multiprocessing.connection import Connection
from pathlib import Path

from hairpipe import child
from hairpipe.errors import BadInput
from hairpipe.graph.engine.keeper import (
    ANSWER,
    HELD,
    IDLE,
    SUFFIX,
    close_all,
    connected,
    receive,
    runtime_folder,
    send,
)
from hairpipe.graph.engine.member import Foreign, Member
from hairpipe.graph.engine.program import program_digest

BOOT = "from hairpipe.graph.engine.keeper import main; main({!r}, {!r})"


@contextmanager
def kept_workers(nodes: Path, idle: float = IDLE) -> Iterator[list[Member]]:
    """Yield the idle workers of earlier runs of this program, and keep those in the list at the end.

    nodes  folder of node types, part of the program
    idle   time without a run after which they end [s]

    BadInput on a system without descriptors of processes, or without a safe folder for a socket.
    """
    if not hasattr(os, "pidfd_open"):
        raise BadInput("workers cannot be kept on this system", where="--keep", right="Linux")
    path = runtime_folder() / f"{program_digest(nodes)}{SUFFIX}"
    spare = taken(path)
    try:
        yield spare
    finally:
        given(path, spare, idle)


def taken(path: Path) -> list[Member]:
    """Take the workers of a keeper; none if there is no keeper."""
    channel = connected(path)
    if channel is None:
        return []
    with closing(channel), suppress(OSError, EOFError):
        send(channel, {"verb": "take"})
        answer, descriptors = receive(channel)
        pairs = zip(*[iter(descriptors)] * HELD, strict=True)
        return [
            Member(found["wide"], Foreign(process), Connection(connection), found["hello"], found["environment"])
            for found, (connection, process) in zip(answer["workers"], pairs, strict=True)
        ]
    return []


def given(path: Path, members: list[Member], idle: float) -> None:
    """Give workers to the keeper, which is started if there is none; end them if it does not answer."""
    alive = [member for member in members if member.process.poll() is None]
    described = [{"wide": m.wide, "hello": m.hello, "environment": m.environment} for m in alive]
    processes = [descriptor_of(member) for member in alive]
    connections = [member.connection.fileno() for member in alive]
    passed = [number for pair in zip(connections, processes, strict=True) for number in pair]
    channel = connected(path) or (started(path, idle) if alive else None)
    if channel is not None:
        with closing(channel), suppress(OSError):
            send(channel, {"verb": "give", "workers": described}, passed)
    close_all(processes)
    for member in members:
        member.connection.close()


def descriptor_of(member: Member) -> int:
    """Return a descriptor of the process of a worker."""
    return member.process.descriptor if isinstance(member.process, Foreign) else os.pidfd_open(member.process.pid)


def started(path: Path, idle: float) -> socket.socket | None:
    """Start a keeper, and connect to it; None if it does not answer."""
    subprocess.Popen(
        child.command(BOOT.format(str(path), idle)),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    end = time.monotonic() + ANSWER
    channel = None
    while channel is None and time.monotonic() < end:
        time.sleep(0.02)
        channel = connected(path)
    return channel
