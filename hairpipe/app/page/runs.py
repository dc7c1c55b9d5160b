"""Runs of a live page in a child process, one at a time: the others wait in a queue.

The process reads a job a line, and reports events line by line; its workers are kept between runs.
"""

import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

from hairpipe import child
from hairpipe.app.api.draft import load_draft
from hairpipe.app.api.graph_shot import Member
from hairpipe.app.api.reports import STATUSES, Status, Task
from hairpipe.app.page.documents import ending
from hairpipe.errors import BadInput

NOTHING: dict[str, Any] = {"failures": [], "computed": 0, "reused": 0, "took": 0.0, "interrupted": False}
"""End of a run without results."""


@dataclass(frozen=True)
class Job:
    """Job of a run: a graph with its edited text, frames, and the cache of the page."""

    graph: str
    edited: str
    frames: list[int] | None
    to: list[str]  # requested nodes, with their dependencies; empty for all
    cache: str
    wedge: str | None  # wedge whose variants are run; None for the graph itself
    quiet: bool = False  # whether nothing is published: the page runs it by itself


def main() -> None:
    """Read jobs from the input until its end, run each, and write its events and its end as lines of JSON."""
    spare: list[Member] = []
    for line in sys.stdin:
        ended = NOTHING | {"interrupted": True}
        with suppress(KeyboardInterrupt):  # of a run that has just ended
            signal.signal(signal.SIGINT, signal.default_int_handler)
            ended = end_of(Job(**json.loads(line)), spare)
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        send({"kind": "ended", **ended})


def end_of(job: Job, spare: list[Member]) -> dict[str, Any]:
    try:
        shot = load_draft(job.graph, job.edited, cache=job.cache).shot
        shot = shot.unpublished() if job.quiet else shot
        run = (shot if job.wedge is None else shot.wedge(job.wedge)).with_workers(spare).run
        return ending(run(job.frames, to=job.to, progress=send_event, keep_going=True))
    except BadInput as fault:
        return NOTHING | {"failures": [str(fault)]}
    except KeyboardInterrupt:
        return NOTHING | {"interrupted": True}


def send_event(event: Any) -> None:
    if event.task is not None:
        send({"kind": event.kind, "node": event.task.node, "frame": event.task.frame, "message": event.message})


def send(document: dict[str, Any]) -> None:
    """Write a line, unless the reader has ended; an interrupt comes before it or after it, never within."""
    try:
        sys.stdout.buffer.write(json.dumps(document).encode() + b"\n")  # `print` writes the end of the line by itself
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        signal.raise_signal(signal.SIGINT)


IDLE = 600.0  # time without a run after which the process of runs ends [s]
Message = dict[str, Any]  # a message of a run: an event, or its end


class Request(NamedTuple):
    """A run that was asked for."""

    job: Job
    label: str  # description of what it differs by
    program: str  # digest of the code with which the process has to begin
    number: int = 0  # by which it is dropped


class Runs:
    """Queue of runs; the first is active. Methods are called with the lock of the session held.

    job       of the active run, or else of the last one
    statuses  of the tasks that the active run, or else the last one, has reached
    last      end of the last run: number of runs so far, label, duration, and those of `documents.ending`
    """

    def __init__(
        self, lock: "threading.RLock", changed: Callable[[], None], found: Callable[[], None], ended: Callable[[], None]
    ) -> None:
        """Call `changed` when a run begins a task, `found` after a result of it, and `ended` after its end."""
        self._lock, self._changed, self._found, self._ended = lock, changed, found, ended
        self._queue: list[Request] = []
        self._program = ""
        self._asked = 0
        self._begun = self._used = 0.0
        self._stopped = False
        self.job: Job | None = None
        self.process: subprocess.Popen[str] | None = None
        self.statuses: dict[Task, Status] = {}
        self.last: Message = {"number": 0}

    def document(self) -> dict[str, Any]:
        """Describe the queue, the time since the active run began [s], and the end of the last run."""
        return ({} if self._queue else self.last) | {
            "running": bool(self._queue),
            "asked": self.asked,
            "queue": [{"number": request.number, "label": request.label} for request in self._queue],
            "since": time.monotonic() - self._begun if self._queue else 0.0,
            "failures": self.last.get("failures", []),
            "last": self.last,
        }

    def add(self, request: Request) -> None:
        """Begin a run, after those in the queue; BadInput for one that is there.

        A quiet run, which the page has begun by itself, gives way to any other one.
        """
        if request.job in [other.job for other in self._queue]:
            raise BadInput("a run is in progress or waits", where=request.label, right="another one after an edit")
        self._asked += 1
        self._queue[1:] = [other for other in self._queue[1:] if not other.job.quiet]
        self._queue.append(request._replace(number=self._asked))
        if self._queue[0].job.quiet and len(self._queue) > 1:
            self._interrupt()
        if len(self._queue) == 1:
            self.last = {"number": self.last["number"]}
            self._begin()

    @property
    def asked(self) -> bool:
        """Whether a run that somebody has asked for is active or waits."""
        return not all(request.job.quiet for request in self._queue)

    def drop(self, number: int) -> None:
        """Remove a waiting run by its number; BadInput where there is none."""
        waiting = self._queue[1:]
        if number not in [request.number for request in waiting]:
            raise BadInput("no such run waits")
        self._queue[1:] = [request for request in waiting if request.number != number]

    def stop(self) -> None:
        """Interrupt the active run, whose results are kept, and empty the queue."""
        del self._queue[1:]
        if self._queue and self.process is not None and self.process.poll() is None:
            self._stopped = True
            # A run without a message has no workers, and may not handle interrupts yet.
            self.process.send_signal(signal.SIGINT if self.statuses else signal.SIGTERM)

    def _interrupt(self) -> None:
        """Interrupt the active run, once it has begun a task: the process and its workers stay for the next one."""
        self._stopped = True
        if self.statuses and self.process is not None and self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)

    def rest(self) -> None:
        """End the process of runs after a while without any."""
        if not self._queue and time.monotonic() - self._used > IDLE:
            self.close()

    def close(self) -> None:
        """Close the input of the process of runs, which then ends with its workers."""
        if self.process is not None and self.process.stdin is not None:
            with suppress(BrokenPipeError):
                self.process.stdin.close()
        self.process = None

    def _begin(self) -> None:
        self.statuses, self._stopped, self._begun = {}, False, time.monotonic()
        self.job = self._queue[0].job
        try:
            stdin = self._ready(self._queue[0].program).stdin
        except OSError as error:
            return self._end({"failures": [f"the run did not start: {error}"], "interrupted": False})
        assert stdin is not None
        with suppress(BrokenPipeError):  # `_listen` notices
            stdin.write(json.dumps(vars(self._queue[0].job)) + "\n")
            stdin.flush()

    def _ready(self, program: str) -> "subprocess.Popen[str]":
        """Return the process of runs; a new one if there is none, or after a change of code."""
        if self._program != program:
            self.close()
        if self.process is None or self.process.poll() is not None:
            self._program = program
            self.process = subprocess.Popen(
                child.command("from hairpipe.app.page.runs import main; main()"),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
                env=child.environment(),
            )
            threading.Thread(target=self._listen, args=(self.process,), daemon=True).start()
        return self.process

    def _listen(self, process: "subprocess.Popen[str]") -> None:
        assert process.stdout is not None
        for line in process.stdout:
            message = json.loads(line)
            with self._lock:
                if message["kind"] == "ended":
                    self._end(message)
                elif message["kind"] in STATUSES:
                    first = not self.statuses
                    self.statuses[Task(message["node"], message["frame"])] = STATUSES[message["kind"]]
                    if first and self._stopped:
                        self._interrupt()
                    (self._changed if message["kind"] == "started" else self._found)()
        process.wait()
        with self._lock:
            if self._queue and process is self.process:
                died = [] if self._stopped else [f"the run ended with exit code {process.returncode}"]
                self._end({"failures": died, "interrupted": self._stopped})

    def _end(self, message: Message) -> None:
        self._used = time.monotonic()
        taken = {"number": self.last["number"] + 1, "label": self._queue.pop(0).label, "took": self._used - self._begun}
        self.last = taken | message
        self.statuses = {task: status for task, status in self.statuses.items() if status != "running"}
        self._ended()
        if self._queue:
            self._begin()
            self._changed()
