"""Runs of a live page in a bridge, one at a time: the others wait in a queue.

The process of the bridge keeps its workers between runs.
"""

import json
import subprocess
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

from hairpipe import child
from hairpipe.app.api.reports import Status, Task
from hairpipe.app.api.selection import fold_frames
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

    def fields(self) -> dict[str, Any]:
        """Return the fields of a request of the bridge."""
        given = {"graph": self.graph, "text": self.edited, "to": self.to, "cache": self.cache}
        frames = {} if self.frames is None else {"frames": fold_frames(self.frames)}
        wedge = {} if self.wedge is None else {"wedge": self.wedge}
        return given | frames | wedge | {"publish": not self.quiet, "keep_going": True, "tasks": True}


IDLE = 600.0  # time without a run after which the process of runs ends [s]
INTERRUPTED = 130  # exit code of a run that was stopped
Message = dict[str, Any]  # an event of the bridge, or the end of a run


def fault_of(message: Message) -> BadInput:
    return BadInput(message["what"], where=message["where"], right=message["right"])


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
        self._failures: list[str] = []
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
        self._interrupt()

    def _interrupt(self) -> None:
        """Interrupt the active run: the process and its workers stay for the next one."""
        if self._queue:
            self._ask(0, "cancel", {"run": self._queue[0].number})

    def _ask(self, number: int, do: str, fields: dict[str, Any]) -> None:
        """Write a request to the bridge, unless its process has ended, which `_listen` notices."""
        if self.process is not None and self.process.stdin is not None:
            with suppress(BrokenPipeError):
                self.process.stdin.write(json.dumps({"id": number, "do": do, **fields}) + "\n")
                self.process.stdin.flush()

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
        self.statuses = {}
        self._failures = []
        self._begun = time.monotonic()
        active = self._queue[0]
        self.job = active.job
        try:
            self._start(active.program)
        except OSError as error:
            return self._end(NOTHING | {"failures": [f"the run did not start: {error}"]})
        self._ask(active.number, "run", active.job.fields())

    def _start(self, program: str) -> None:
        """Start a process of runs if there is none, or after a change of code; OSError where that fails."""
        if self._program != program:
            self.close()
        if self.process is None or self.process.poll() is not None:
            self._program = program
            self.process = subprocess.Popen(
                child.command("from hairpipe.app.bridge import main; main()"),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
                env=child.environment(),
            )
            threading.Thread(target=self._listen, args=(self.process,), daemon=True).start()

    def _listen(self, process: "subprocess.Popen[str]") -> None:
        assert process.stdout is not None
        for line in process.stdout:
            with self._lock:
                self._take(json.loads(line))
        process.wait()
        with self._lock:
            if self._queue and process is self.process:
                self._end(NOTHING | {"failures": [f"the run ended with exit code {process.returncode}"]})

    def _take(self, message: Message) -> None:
        """Note an event of the active run."""
        if not self._queue or message.get("id") != self._queue[0].number:
            return
        match message:
            case {"event": "task", "node": node, "frame": frame, "status": status}:
                self.statuses[Task(node, frame)] = status
                (self._changed if status == "running" else self._found)()
            case {"event": "failed", "node": node, "frame": frame}:
                self._failures.append(f"{Task(node, frame)}: {fault_of(message)}")
            case {"event": "error"}:
                self._end(NOTHING | {"failures": [str(fault_of(message))]})
            case {"event": "done", "exit_code": code, "computed": computed, "cached": cached, "seconds": seconds}:
                counts = {"computed": computed, "reused": cached, "took": seconds}
                self._end(counts | {"failures": self._failures, "interrupted": code == INTERRUPTED})

    def _end(self, message: Message) -> None:
        self._used = time.monotonic()
        taken = {"number": self.last["number"] + 1, "label": self._queue.pop(0).label, "took": self._used - self._begun}
        self.last = taken | message
        self.statuses = {task: status for task, status in self.statuses.items() if status != "running"}
        self._ended()
        if self._queue:
            self._begin()
            self._changed()
