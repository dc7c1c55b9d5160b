"""Follows a run: counts its progress, passes on what it has to say, and draws it on whatever the terminal can do."""

import os
import sys
from types import TracebackType
from typing import Protocol, Self

from hairpipe.cli.lines import Lines, Silence
from hairpipe.graph.file.graph import Graph
from hairpipe.graph.plan.tasks import Task
from hairpipe.graph.run.events import Event, Progress


class Drawing(Protocol):
    """A way to show progress."""

    def begin(self) -> None:
        """Begin to draw."""

    def update(self, event: Event) -> None:
        """Draw what an event has changed; the progress knows of it already."""

    def say(self, line: str) -> None:
        """Write a line that stays."""

    def end(self) -> None:
        """Stop drawing."""


class Watch:
    """Takes the events of a run in, as a context that draws.

    warnings  tasks by node and message, in the order in which they came
    """

    def __init__(self, graph: Graph, jobs: int, *, quiet: bool) -> None:
        self.progress = Progress(graph, jobs)
        self.warnings: dict[tuple[str, str], list[Task]] = {}
        self._drawing = choose_drawing(self.progress, quiet)

    def __call__(self, event: Event) -> None:
        """Take an event in."""
        self.progress.update(event)
        if event.kind == "warning" and event.task is not None:
            tasks = self.warnings.setdefault((event.task.node, event.message), [])
            tasks.append(event.task)
            if len(tasks) == 1:
                self._drawing.say(f"warning: {event.task}: {event.message}")
        elif event.kind == "failed":
            self._drawing.say(f"failed: {event.task}: {event.message}")
        self._drawing.update(event)

    def __enter__(self) -> Self:
        """Begin to draw."""
        self._drawing.begin()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop drawing."""
        self._drawing.end()


def choose_drawing(progress: Progress, quiet: bool) -> Drawing:
    """Bars on a terminal, lines elsewhere, nothing where that was asked for; rich is imported for bars only."""
    if quiet:
        return Silence()
    if sys.stderr.isatty() and os.environ.get("TERM") != "dumb":
        from hairpipe.cli.bars import Bars

        return Bars(progress)
    return Lines(progress)
