"""The keeper: a process of the user that holds idle workers between runs, and ends when nobody asks for ten minutes.

It holds one end of the connection of each worker, and passes it on as a file descriptor: workers end when that end is
closed, so they end with the keeper, and with a run that is killed. A keeper serves one program, see `program_digest`:
runs with other code, versions or checkouts have keepers of their own. Its socket lies in a folder that only the user
can enter, and every connection is checked for its user.

Workers that outlive a run: taken from the keeper of the user before the run, and given back after it.
"""

import fcntl
import json
import os
import select
import socket
import struct
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from hairpipe import child
from hairpipe.engine.hosts.member import Foreign, Member
from hairpipe.engine.hosts.offer import program_digest
from hairpipe.engine.store.ownership import fault_of
from hairpipe.errors import BadInput

IDLE = 600.0
"""Time without a request after which a keeper ends [s]."""
ANSWER = 5.0
"""Time within which either side must answer [s]."""
HELD = 2
"""Descriptors of a worker: its connection, and its process."""
MOST_PASSED = 200
"""Maximum number of descriptors in one message; that of Linux is 253."""
SUFFIX = ".workers"
LOCK = "lock"

Message = dict[str, Any]


def runtime_folder() -> Path:
    """Make the folder of the sockets of this user; BadInput if it is not safe, OSError if it cannot be made."""
    given = Path(os.environ.get("XDG_RUNTIME_DIR", ""))
    safe = given.is_absolute() and given.is_dir() and fault_of(given) is None
    folder = given / "hairpipe" if safe else Path(tempfile.gettempdir(), f"hairpipe-{os.geteuid()}")
    folder.mkdir(mode=0o700, exist_ok=True)
    if fault := fault_of(folder):
        raise BadInput(f"the folder of sockets {fault}", where=folder, right="XDG_RUNTIME_DIR of your own")
    return folder


def connected(path: Path) -> socket.socket | None:
    """Connect to a keeper; None if none answers, or that of another user."""
    channel = socket.socket(socket.AF_UNIX)
    channel.settimeout(ANSWER)
    with suppress(OSError), short(path) as name:
        channel.connect(name)
        if user_of(channel) == os.geteuid():
            return channel
    channel.close()
    return None


def send(channel: socket.socket, message: Message, descriptors: Sequence[int] = ()) -> None:
    """Send a message with file descriptors; OSError if the other side has ended."""
    text = json.dumps(message | {"descriptors": len(descriptors)}).encode()
    channel.sendall(struct.pack("!I", len(text)) + text)
    for begin in range(0, len(descriptors), MOST_PASSED):
        socket.send_fds(channel, [b"\0"], descriptors[begin : begin + MOST_PASSED])


def receive(channel: socket.socket) -> tuple[Message, list[int]]:
    """Receive a message with file descriptors; OSError or EOFError if the other side has ended."""
    message: Message = json.loads(exactly(channel, *struct.unpack("!I", exactly(channel, 4))))
    descriptors: list[int] = []
    while len(descriptors) < message["descriptors"]:
        byte, found, _, _ = socket.recv_fds(channel, 1, MOST_PASSED)
        descriptors += found
        if not byte:
            close_all(descriptors)
            raise EOFError
    return message, descriptors


def exactly(channel: socket.socket, count: int) -> bytes:
    """Receive a number of bytes; EOFError if the other side ends before."""
    data = bytearray()
    while len(data) < count:
        found = channel.recv(count - len(data))
        if not found:
            raise EOFError
        data += found
    return bytes(data)


def user_of(channel: socket.socket) -> int:
    """Return the user of the process at the other end."""
    _, user, _ = struct.unpack("3i", channel.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i")))
    return user


def close_all(descriptors: Sequence[int]) -> None:
    """Close file descriptors."""
    for descriptor in descriptors:
        os.close(descriptor)


@contextmanager
def short(path: Path) -> Iterator[str]:
    """Yield a short path of a socket in an open folder: a path in an address has at most 107 bytes."""
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        yield f"/proc/self/fd/{folder}/{path.name}"
    finally:
        os.close(folder)


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock the folder of sockets, for whoever makes or removes one."""
    with (folder / LOCK).open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def main(path: str, idle: float = IDLE) -> None:
    """Serve at a socket until it is idle; end at once if another keeper does."""
    os.umask(0o177)
    os.chdir("/")
    place = Path(path)
    with closing(socket.socket(socket.AF_UNIX)) as server:
        with locked(place.parent):
            other = connected(place)
            if other is not None:
                other.close()
                return
            place.unlink(missing_ok=True)
            with short(place) as name:
                server.bind(name)
            server.listen()
        try:
            serve(server, idle)
        finally:
            with locked(place.parent):
                place.unlink(missing_ok=True)


def serve(server: socket.socket, idle: float) -> None:
    """Answer requests, one after another, until the end of an idle time or a request to end."""
    workers: list[Message] = []
    descriptors: list[int] = []
    end = time.monotonic() + idle
    while select.select([server], [], [], max(0.0, end - time.monotonic()))[0]:
        channel = server.accept()[0]
        channel.settimeout(ANSWER)
        with closing(channel), suppress(OSError, EOFError, ValueError, KeyError):
            if user_of(channel) != os.geteuid():
                continue
            request, passed = receive(channel)
            if request["verb"] in ("count", "end"):
                send(channel, {"count": len(workers), "left": end - time.monotonic()})
                if request["verb"] == "end":
                    return
                continue
            end = time.monotonic() + idle
            sent, held = workers, descriptors
            workers = request.get("workers", [])
            descriptors = passed
            try:
                if request["verb"] == "take":
                    send(channel, {"workers": sent}, held)
            finally:
                close_all(held)  # workers that nobody has taken end


BOOT = "from hairpipe.engine.hosts.keeper import main; main({!r}, {!r})"


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
