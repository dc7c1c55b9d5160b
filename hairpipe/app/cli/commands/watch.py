"""`hairpipe watch`: progress of a run of any machine, read from the cache alone."""

import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import hairpipe
from hairpipe.app.cli import options

if TYPE_CHECKING:
    from hairpipe.app.api.reports import Survey

INTERVAL = 2.0
"""Time between two reads of the cache [s]."""


@click.command()
@options.graph
@options.frames
@options.overrides
@options.to
@options.wedge
@options.cache
@click.option("--once", is_flag=True, help="Report the present state, and end.")
@options.as_json
def watch(
    graph: str,
    frames: tuple[int, ...] | None,
    overrides: dict[str, str],
    to: tuple[str, ...],
    wedge: str | None,
    cache: Path,
    once: bool,
    as_json: bool,
) -> None:
    """Follow a run of any machine, read from the cache alone.

    Reports which results exist and which are computed now, until all exist; nothing is computed or written. The run
    may be of any process or machine that shares the cache: give this command the same graph and options. A result is
    "waiting" until its inputs exist, since its key is made of them, and "missing" if they exist and no process computes
    it. A failure is reported, with its machine, until a run starts the same computation again.

    On a terminal a table is redrawn every two seconds, elsewhere changes are written line by line; with --json each
    state is one document on one line. Exit codes: 0 all results exist, 1 not all (with --once).
    """
    shot = hairpipe.load(graph, options.parsed(overrides), cache=cache)
    shot = shot if wedge is None else shot.wedge(wedge)
    survey = shot.survey(frames, to=to)
    with reporting(as_json) as report:
        report(survey)
        while not (once or survey.complete):
            time.sleep(INTERVAL)
            survey.update()
            report(survey)
    sys.exit(0 if survey.complete else 1)


@contextmanager
def reporting(as_json: bool) -> Iterator[Callable[["Survey"], None]]:
    """Choose documents, a table on a terminal, or lines elsewhere; rich is imported for the table only."""
    from hairpipe.app.cli.run_display import SurveyLines

    if as_json:
        yield lambda survey: click.echo(json.dumps(document(survey)))
    elif sys.stdout.isatty() and os.environ.get("TERM") != "dumb":
        from hairpipe.app.cli.run_display import SurveyBars

        bars = SurveyBars()
        try:
            yield bars
        finally:
            bars.end()
    else:
        yield SurveyLines()


def document(survey: "Survey") -> dict[str, Any]:
    return {
        "complete": survey.complete,
        "seconds_left": survey.seconds_left,
        "computing": [task._asdict() | {"host": host} for task, host in survey.hosts.items()],
        "failed": [task._asdict() | failure._asdict() for task, failure in survey.failures.items()],
        "nodes": {
            name: {
                "computed": node.done,
                "computing": len(node.running),
                "missing": node.missing,
                "failed": node.failures.total(),
                "waiting": node.waiting,
                "diverged": node.diverged,
                "seconds_each": node.seconds_per_frame,
                "seconds_left": node.seconds_left,
            }
            for name, node in survey.nodes.items()
        },
    }
