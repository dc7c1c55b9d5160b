"""Runs in a child process, which reports events line by line; its workers are kept between runs."""

import json
import signal
import sys
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from hairpipe.app.api.draft import load_draft
from hairpipe.app.api.graph_shot import Member
from hairpipe.app.page.documents import ending
from hairpipe.errors import BadInput

NOTHING: dict[str, Any] = {"failures": [], "computed": 0, "reused": 0, "took": 0.0, "interrupted": False}
"""End of a run without results."""


@dataclass(frozen=True)
class Job:
    """Job of a run: a graph with its edited text, frames, and the cache of the page.

    to     requested nodes, with their dependencies; empty for all
    wedge  wedge whose variants are run; None for the graph itself
    quiet  whether nothing is published: the page runs it by itself
    """

    graph: str
    edited: str
    frames: list[int] | None
    to: list[str]
    cache: str
    wedge: str | None
    quiet: bool = False

    @property
    def text(self) -> str:
        """The job as one line."""
        return json.dumps(vars(self))


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
        if job.quiet:
            shot = shot.edited({name: without_publishing(table) for name, table in shot.tables.items()})
        run = (shot if job.wedge is None else shot.wedge(job.wedge)).with_workers(spare).run
        return ending(run(job.frames, to=job.to, progress=send_event, keep_going=True))
    except BadInput as fault:
        return NOTHING | {"failures": [str(fault)]}
    except KeyboardInterrupt:
        return NOTHING | {"interrupted": True}


def without_publishing(table: Any) -> Any:
    """Return the table of a node without the place of its published files; other values as they are."""
    return {name: value for name, value in table.items() if name != "publish"} if isinstance(table, dict) else table


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
