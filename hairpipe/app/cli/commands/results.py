"""Results of a graph in the cache: planned, computed by any machine, explained, and written to files."""

import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hairpipe.app.api.formatting import shown, size
from hairpipe.app.cli import options

if TYPE_CHECKING:
    from hairpipe.app.api.graph_shot import GraphShot
    from hairpipe.app.api.reports import Survey
    from hairpipe.app.api.selection import Target
    from hairpipe.app.api.shot import Shot


@click.command()
@options.shot_or_wedge
@options.frames
@options.to
@options.publish_root
@click.option("--missing", is_flag=True, help="Report only results that are not cached; exit code 1 if there are any.")
@options.as_json
def plan(
    shot: "GraphShot",
    frames: tuple[int, ...] | None,
    to: tuple[str, ...],
    publish_root: Path | None,
    missing: bool,
    as_json: bool,
) -> None:
    """Report what a run would do to every node and frame, and why. Nothing is computed or written.

    "will run" gives the first difference to the latest result; `hairpipe explain` gives all of them. "depends on X"
    runs only if the new result of X differs from the previous one.
    """
    found = shot.plan(frames, to=to, publish_root=publish_root)
    found = found.missing if missing else found
    click.echo(json.dumps(found.document(), indent=2) if as_json else found)
    if missing and len(found):
        sys.exit(1)


@click.command()
@options.shot
@options.target
@options.frames
@options.as_json
def explain(shot: "Shot", target: "Target", frames: tuple[int, ...] | None, as_json: bool) -> None:
    """Explain one result: inputs, state, what is different.

    The result is that of a node at a frame, `hair@12`, or of a node that has one value for the shot, `groom`.
    """
    found = shot.explain(target, frames=frames)
    click.echo(json.dumps(found.document(), indent=2) if as_json else repr(found))


@click.command()
@options.shot
@options.target
@options.frames
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="Path of the file to write.")
def get(shot: "Shot", target: "Target", frames: tuple[int, ...] | None, output: Path) -> None:
    """Write a result to a file.

    The format is given by the suffix: HDF5 (.h5), NPZ (.npz), CSV (.csv) or USD (.usd, .usda, .usdc).

    NODE@FRAME is the first output of a node at a frame, NODE.OUTPUT@FRAME another one. HDF5 and NPZ hold any value;
    CSV and USD meshes and hair. A result that is a file is copied unchanged.

    A result that depends on all frames of a run is found with the --frames of that run.
    """
    shot.write(target, output, frames=frames)
    click.echo(f"{shown(output)}  {size(output.stat().st_size)}")


WATCHED = 2.0  # time between two reads of the cache [s]


@click.command()
@options.shot_or_wedge
@options.frames
@options.to
@click.option("--once", is_flag=True, help="Report the present state, and end.")
@options.as_json
def watch(shot: "GraphShot", frames: tuple[int, ...] | None, to: tuple[str, ...], once: bool, as_json: bool) -> None:
    """Follow a run of any machine, read from the cache alone.

    Reports which results exist and which are computed now, until all exist; nothing is computed or written. The run
    may be of any process or machine that shares the cache: give this command the same graph and options. A result is
    "waiting" until its inputs exist, since its key is made of them, and "missing" if they exist and no process computes
    it. A failure is reported, with its machine, until a run starts the same computation again.

    On a terminal a table is redrawn every two seconds, elsewhere changes are written line by line; with --json each
    state is one document on one line. Exit codes: 0 all results exist, 1 not all (with --once).
    """
    survey = shot.survey(frames, to=to)
    with reporting(as_json) as report:
        report(survey)
        while not (once or survey.complete):
            time.sleep(WATCHED)
            survey.update()
            report(survey)
    sys.exit(0 if survey.complete else 1)


@contextmanager
def reporting(as_json: bool) -> Iterator[Callable[["Survey"], None]]:
    """Choose documents, a table on a terminal, or lines elsewhere; rich is imported for the table only."""
    from hairpipe.app.cli.run_display import SurveyLines

    if as_json:
        yield lambda survey: click.echo(json.dumps(survey_document(survey)))
    elif sys.stdout.isatty() and os.environ.get("TERM") != "dumb":
        from hairpipe.app.cli.run_display import SurveyBars

        bars = SurveyBars()
        try:
            yield bars
        finally:
            bars.end()
    else:
        yield SurveyLines()


def survey_document(survey: "Survey") -> dict[str, Any]:
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
