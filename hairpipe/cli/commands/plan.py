"""`hairpipe plan`: what a run would do, and why."""

import json
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hairpipe.cli import options
from hairpipe.cli.wording import plural, table

if TYPE_CHECKING:
    from hairpipe.graph.plan.planner import Entry


@click.command()
@options.graph
@options.frames
@options.overrides
@options.to
@options.publish_root
@options.cache
@options.as_json
def plan(
    graph: str,
    frames: tuple[int, ...] | None,
    overrides: dict[str, str],
    to: tuple[str, ...],
    publish_root: Path | None,
    cache: Path,
    as_json: bool,
) -> None:
    """Say what a run would do, and why.

    Every node and frame is looked at; nothing is run, nothing is written.

    "will run" gives the first difference to the latest result; `hairpipe explain` gives all of them. "depends on X"
    runs only if X comes out different from before.
    """
    from hairpipe.cli.shipped import open_graph
    from hairpipe.graph.file.bounds import Bounds
    from hairpipe.graph.plan.planner import plan as make_plan
    from hairpipe.graph.store.store import Store

    opened = open_graph(graph, overrides, to)
    Bounds(opened, cache, publish_root).check()
    entries = make_plan(opened, Store(cache), frames)
    if as_json:
        tasks = [entry.task._asdict() | {"status": entry.status, "reason": entry.reason} for entry in entries]
        click.echo(json.dumps({"tasks": tasks}, indent=2))
    else:
        click.echo(table(rows_of(entries), "<<<"))
        click.echo(total(entries))


def rows_of(entries: Iterable["Entry"]) -> list[tuple[str, str, str]]:
    """Fold the frames of each node that share a fate: node, frames, what and why."""
    from hairpipe.graph.file.frameset import fold_frames

    groups: dict[tuple[str, str], list[int]] = {}
    for entry in entries:
        frames = groups.setdefault((entry.task.node, fate(entry)), [])
        frames += [] if entry.task.frame is None else [entry.task.frame]
    rows, known = [], set()
    for (node, what), frames in groups.items():
        rows.append(("" if node in known else node, fold_frames(frames), what))
        known.add(node)
    return rows


def fate(entry: "Entry") -> str:
    """Say what would happen to a task, in words that are the same for like frames."""
    if entry.status == "cached":
        return "cached"
    if entry.status == "run":
        return f"will run: {entry.reason}"
    return f"depends on {entry.reason.partition('@')[0]}"


def total(entries: Iterable["Entry"]) -> str:
    """Count the tasks."""
    counts = Counter(entry.status for entry in entries)
    waiting = f", {counts['depends']:,} depend on what comes out" if counts["depends"] else ""
    return f"{plural(counts['run'], 'result')} to compute{waiting}, {counts['cached']:,} cached"
