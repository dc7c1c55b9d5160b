"""Run in a child process, which reports its events line by line; the page may stop it."""

import json
import signal
import sys
from dataclasses import dataclass
from typing import Any

import hairpipe
from hairpipe.errors import BadInput
from hairpipe.page.documents import ending


@dataclass(frozen=True)
class Job:
    """Job of a run: a graph with settings, frames, and the cache of the page.

    to     requested nodes, with their dependencies; empty for all
    wedge  wedge whose variants are run; None for the graph itself
    """

    graph: str
    settings: dict[str, Any]
    frames: list[int] | None
    to: list[str]
    cache: str
    wedge: str | None

    @property
    def text(self) -> str:
        """The job as one line."""
        return json.dumps(vars(self))


def main() -> None:
    """Read a job from the input, run it, and write its events and its end as lines of JSON."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    job = Job(**json.loads(sys.stdin.readline()))
    try:
        shot = hairpipe.load(job.graph, job.settings, cache=job.cache)
        shot = shot if job.wedge is None else shot.wedge(job.wedge)
        done = shot.run(job.frames, to=job.to, progress=send_event, keep_going=True)
        ended: dict[str, Any] = {"kind": "ended", **ending(done)}
    except BadInput as fault:
        ended = {
            "kind": "ended",
            "failures": [str(fault)],
            "computed": 0,
            "reused": 0,
            "took": 0.0,
            "interrupted": False,
        }
    except KeyboardInterrupt:
        ended = {"kind": "ended", "failures": [], "computed": 0, "reused": 0, "took": 0.0, "interrupted": True}
    send(ended)


def send_event(event: Any) -> None:
    """Write an event."""
    if event.task is not None:
        send({"kind": event.kind, "node": event.task.node, "frame": event.task.frame, "message": event.message})


def send(document: dict[str, Any]) -> None:
    """Write a line, unless the reader has ended."""
    try:
        print(json.dumps(document), flush=True)
    except BrokenPipeError:
        signal.raise_signal(signal.SIGINT)
