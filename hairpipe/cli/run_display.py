"""Display of a run: progress by bars on a terminal, or by lines."""

import os
import sys
from types import TracebackType
from typing import Protocol, Self

from hairpipe.api.reports import Event, Graph, Progress
from hairpipe.api.warming import NOTICE, compiles_first
from hairpipe.cli.lines import Lines, NoProgress


class Drawing(Protocol):
    """A way to show progress."""

    def begin(self) -> None:
        """Begin to draw."""

    def update(self, event: Event) -> None:
        """Draw the change by an event, which the progress contains already."""

    def echo(self, line: str) -> None:
        """Write a permanent line."""

    def end(self) -> None:
        """Stop drawing."""


class RunDisplay:
    """Context that receives the events of a run, and draws its progress."""

    def __init__(self, graph: Graph, jobs: int, *, quiet: bool) -> None:
        self.progress = Progress(graph, jobs)
        self._said: set[tuple[str, str]] = set()
        self._drawing = choose_drawing(self.progress, quiet)
        self._compiles = not quiet and compiles_first(graph)

    def __call__(self, event: Event) -> None:
        """Show an event; the same warning of a node once for all frames."""
        self.progress.update(event)
        if event.kind == "started" and self._compiles:
            self._compiles = False
            self._drawing.echo(NOTICE)
        if event.kind == "warning" and event.task is not None:
            if (event.task.node, event.message) not in self._said:
                self._said.add((event.task.node, event.message))
                self._drawing.echo(f"warning: {event.task}: {event.message}")
        elif event.kind == "failed":
            self._drawing.echo(f"failed: {event.task}: {event.message}")
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
    """Choose bars on a terminal, lines elsewhere, nothing if quiet; rich is imported for bars only."""
    if quiet:
        return NoProgress()
    if sys.stderr.isatty() and os.environ.get("TERM") != "dumb":
        from hairpipe.cli.bars import Bars

        return Bars(progress)
    return Lines(progress)
