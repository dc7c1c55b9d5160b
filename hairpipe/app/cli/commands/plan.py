"""`hairpipe plan`: planned computation, with reasons."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import click

import hairpipe
from hairpipe.app.cli import options


@click.command()
@options.graph
@options.frames
@options.overrides
@options.to
@options.wedge
@options.publish_root
@click.option("--missing", is_flag=True, help="Report only results that are not cached; exit code 1 if there are any.")
@options.cache
@options.as_json
def plan(
    graph: str,
    frames: tuple[int, ...] | None,
    overrides: dict[str, str],
    to: tuple[str, ...],
    wedge: str | None,
    publish_root: Path | None,
    missing: bool,
    cache: Path,
    as_json: bool,
) -> None:
    """Report what a run would do to every node and frame, and why. Nothing is computed or written.

    "will run" gives the first difference to the latest result; `hairpipe explain` gives all of them. "depends on X"
    runs only if the new result of X differs from the previous one.
    """
    shot = hairpipe.load(graph, options.parsed(overrides), cache=cache)
    shot = shot if wedge is None else shot.wedge(wedge)
    found = shot.plan(frames, to=to, publish_root=publish_root)
    if missing:
        found = replace(found, entries=tuple(entry for entry in found if entry.status != "cached"))
    if as_json:
        tasks = [entry.task._asdict() | {"status": entry.status, "reason": entry.reason} for entry in found]
        click.echo(json.dumps({"tasks": tasks, "stopped": found.stopped}, indent=2))
    else:
        click.echo(found)
    if missing and len(found):
        sys.exit(1)
