"""Runs in a child process, which reports events line by line; its workers are kept between runs."""

import json
import signal
import sys
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from hairpipe.api.draft import load_draft
from hairpipe.api.graph_shot import Member
from hairpipe.errors import BadInput
from hairpipe.page.documents import ending


@dataclass(frozen=True)
class Job:
    """Job of a run: a graph with its edited text, frames, and the cache of the page.

    to     requested nodes, with their dependencies; empty for all
    wedge  wedge whose variants are run; None for the graph itself
    """

    graph: str
    edited: str
    frames: list[int] | None
    to: list[str]
    cache: str
    wedge: str | None

    @property
    def text(self) -> str:
        """The job as one line."""
        return json.dumps(vars(self))


def main() -> None:
    """Read jobs from the input until its end, run each, and write its events and its end as lines of JSON."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    spare: list[Member] = []
    with suppress(KeyboardInterrupt):  # of a run that has just ended
        for line in sys.stdin:
            send({"kind": "ended", **end_of(Job(**json.loads(line)), spare)})


def end_of(job: Job, spare: list[Member]) -> dict[str, Any]:
    """Run a job with spare workers, and describe its end."""
    ended = {"failures": list[str](), "computed": 0, "reused": 0, "took": 0.0, "interrupted": False}
    try:
        shot = load_draft(job.graph, job.edited, cache=job.cache).shot
        run = (shot if job.wedge is None else shot.wedge(job.wedge)).with_workers(spare).run
        return ending(run(job.frames, to=job.to, progress=send_event, keep_going=True))
    except BadInput as fault:
        return ended | {"failures": [str(fault)]}
    except KeyboardInterrupt:
        return ended | {"interrupted": True}


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
