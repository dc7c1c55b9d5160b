"""Workers for tests, each forked from one process that has imported what all of them import.

Python and its imports are three quarters of what the worker of a small job costs, and most tests that start workers
test something else. A forked worker serves with the environment, module path, descriptors, folder and mask that a
started one would have.
"""

import fcntl
import gc
import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
import traceback
from pathlib import Path

from hairpipe.engine.hosts.host import interrupts_blocked

READ_AT_IMPORT = ("LD_", "MKL_", "NPY_", "OPENBLAS_", "PYTHON", "VECLIB_")
"""Beginnings of the variables that must be those of the process which is forked: they were read while it imported."""
HIGH = 400
"""Descriptors from here on are those that no worker is given."""
LONGEST = 1 << 20
"""Largest size of a message [bytes]."""


class ForkedWorker:
    """A worker with the parts of `subprocess.Popen` that a `Member` uses."""

    def __init__(self, source: "Source", request: dict, descriptors: list[int]) -> None:
        self._source = source
        self.pid: int = source.ask(request, descriptors)
        self.returncode: int | None = None

    def poll(self) -> int | None:
        """Return the exit code, None while the process runs."""
        if self.returncode is None:
            self.returncode = self._source.ask({"wait": self.pid})
        return self.returncode

    def wait(self) -> int | None:
        """Wait for the end of the process."""
        if self.poll() is None:
            descriptor = os.pidfd_open(self.pid)
            select.select([descriptor], [], [])
            os.close(descriptor)
        return self.poll()

    def send_signal(self, number: int) -> None:
        """Send a signal to the process, where it has not ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """Kill the process."""
        self.send_signal(signal.SIGKILL)


class Source:
    """The process that is forked: one, with the environment of the first worker."""

    first: "Source | None" = None

    def __init__(self, environment: dict[str, str]) -> None:
        self.environment = read_at_import(environment)
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        command = [sys.executable, "-P", Path(__file__), str(theirs.fileno()), json.dumps(sys.path)]
        with theirs, interrupts_blocked():
            self._process = subprocess.Popen(command, pass_fds=[theirs.fileno()], env=environment, cwd="/")
        self._channel, self._lock, self._number = ours, threading.Lock(), 0

    def ask(self, request: dict, descriptors: list[int] | None = None) -> int | None:
        """Send a request, and wait for its answer; one to a request whose sender was interrupted is passed over."""
        with self._lock:
            self._number += 1
            message = json.dumps(request | {"number": self._number}).encode()
            socket.send_fds(self._channel, [message], descriptors or [])
            while True:
                number, answer = json.loads(self._channel.recv(LONGEST))
                if number == self._number:
                    return answer


def start(command: list[str], *, pass_fds: list[int], stdout: int, env: dict[str, str], **others):
    """Start a worker as `subprocess.Popen` does; in a process of its own where a forked one would differ."""
    try:
        folder = str(Path.cwd())
    except FileNotFoundError:
        folder = None
    source = Source.first = Source.first or Source(env)
    if folder is None or source.environment != read_at_import(env):
        return subprocess.Popen(command, pass_fds=pass_fds, stdout=stdout, env=env, **others)
    request = {"path": command[-1], "environment": env, "folder": folder, "mask": read_umask()}
    request |= {"descriptor": pass_fds[0]}
    with Path(os.devnull).open("r+b", buffering=0) as nothing:
        output = nothing.fileno() if stdout == subprocess.DEVNULL else stdout
        return ForkedWorker(source, request, [nothing.fileno(), output, output, pass_fds[0]])


def read_at_import(environment: dict[str, str]) -> dict[str, str]:
    """Select the variables that numpy and Python read once."""
    return {name: value for name, value in environment.items() if name.startswith(READ_AT_IMPORT)}


def read_umask() -> int:
    """Read the mask of this process; to set it and set it back would change it for other threads."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1], 8) for line in lines if line.startswith("Umask:"))


def serve(channel: socket.socket) -> None:
    """Fork workers, and report their exit codes, as often as they are asked for, until the channel is closed."""
    codes: dict[int, int] = {}
    while True:
        message, descriptors, _, _ = socket.recv_fds(channel, LONGEST, 8)
        if not message:
            return
        request = json.loads(message)
        if "wait" in request:
            ended, status = (0, 0) if request["wait"] in codes else os.waitpid(request["wait"], os.WNOHANG)
            if ended:
                codes[ended] = os.waitstatus_to_exitcode(status)
            answer = codes.get(request["wait"])
        else:
            answer = os.fork()
            codes.pop(answer, None)
            if answer == 0:
                channel.close()
                become(request, descriptors)
            for descriptor in descriptors:
                os.close(descriptor)
        channel.send(json.dumps([request["number"], answer]).encode())


def become(request: dict, descriptors: list[int]) -> None:
    """Turn this forked process into the worker of a request; does not return."""
    code = 1
    try:
        given = [fcntl.fcntl(descriptor, fcntl.F_DUPFD, HIGH) for descriptor in descriptors]
        for descriptor in descriptors:
            os.close(descriptor)
        for descriptor, place in zip(given, (0, 1, 2, request["descriptor"]), strict=True):
            os.dup2(descriptor, place)
            os.close(descriptor)
        os.umask(request["mask"])
        os.chdir(request["folder"])
        os.environ.clear()
        os.environ.update(request["environment"])
        sys.path[:] = json.loads(request["path"])
        worker.main(request["descriptor"])
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(code)


if __name__ == "__main__":
    sys.path[:] = json.loads(sys.argv[2])
    from hairpipe.engine.worker import worker

    gc.freeze()
    low = int(sys.argv[1])
    with socket.socket(fileno=fcntl.fcntl(low, fcntl.F_DUPFD_CLOEXEC, HIGH)) as requests:
        os.close(low)
        serve(requests)
