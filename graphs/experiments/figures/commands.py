"""The commands on recorded figures: they record tables, list which are current, and write pages."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

import hairpipe
from hairpipe.api.formatting import duration, plural, shown, table
from hairpipe.cli import options, summary
from hairpipe.cli.entry import Group
from hairpipe.cli.housekeeping.trust import asking
from hairpipe.cli.watch import Watch

if TYPE_CHECKING:
    from hairpipe.graphs.experiments.figures.state import State

NAMED = 3
"""Number of changes that are named for each results file."""
paths = click.argument("paths", nargs=-1, metavar="[PATH]...", type=click.Path(path_type=Path))


@click.group(cls=Group)
def figures() -> None:
    """Record measured figures, and write them into pages."""


@figures.command()
@options.graph
@options.frames
@options.overrides
@options.to
@options.wedge
@options.jobs
@click.option("--name", metavar="NAME", help="Name of the results file; by default GRAPH, or GRAPH_WEDGE.")
@options.cache
def record(
    graph: str,
    frames: tuple[int, ...] | None,
    overrides: dict[str, str],
    to: tuple[str, ...],
    wedge: str | None,
    jobs: int,
    name: str | None,
    cache: Path,
) -> None:
    """Run a graph, and write its tables and what its nodes cost to results/NAME.json next to it.

    With --wedge the tables of all variants are written below each other, after columns of what they vary.

    Exit codes: 0 all is computed, 1 a node failed, 2 bad input.
    """
    from hairpipe.graphs.experiments.figures.recording import Recording

    shot = asking(lambda: hairpipe.load(graph, options.parsed(overrides), cache=cache))
    shot = shot if wedge is None else shot.wedge(wedge)
    recording = Recording(shot, name, overrides, frames, to)
    with Watch(shot.graph, jobs, quiet=False) as watch:
        done = shot.run(frames, to=to, jobs=jobs, progress=watch)
    if done.ok:
        recording.write(done)
    summary.report_faults(done, False)
    sys.exit(done.outcome.exit_code)


@figures.command("list")
@paths
@options.as_json
def list_results(paths: tuple[Path, ...], as_json: bool) -> None:
    """List recorded figures and whether they are current.

    The list names the code and nodes that have changed since, and the cost of a new measurement.

    PATH is a page, a graph, a results file, or a folder; the current folder without one. Results are current where
    code, settings and files are as they were when the results were recorded.

    Exit codes: 0 all results are current; 1 some are not current; 2 bad input.
    """
    from hairpipe.graphs.experiments.figures.finding import find_results
    from hairpipe.graphs.experiments.figures.state import CURRENT, state_of

    states = [state_of(path) for path in find_results(paths or (Path(),))]
    if as_json:
        click.echo(json.dumps({"results": [document(state) for state in states]}, indent=2))
    else:
        show(states)
    sys.exit(0 if all(state.word == CURRENT for state in states) else 1)


@figures.command()
@paths
def write(paths: tuple[Path, ...]) -> None:
    """Write the figures into pages, and name those that have changed.

    PATH is a page or a folder; the current folder without one.
    """
    from functools import cache

    from hairpipe.graph.store.atomic import write_text
    from hairpipe.graphs.experiments.figures.finding import find_pages, read_page
    from hairpipe.graphs.experiments.figures.pages import written_page
    from hairpipe.graphs.experiments.figures.state import state_of

    word_of = cache(lambda path: state_of(path).word)
    for page in find_pages(paths or (Path(),)):
        before = read_page(page)
        after = written_page(page, before, word_of)
        if after != before:
            write_text(page, after)
            click.echo(shown(page))


def document(state: "State") -> dict[str, object]:
    """Describe the state of results as a JSON document."""
    found = state.results
    return {
        "path": str(state.path),
        "state": state.word,
        "changed": list(state.changed),
        "commit": found.commit,
        "command": found.command,
        "processor": found.processor,
    }


def show(states: list["State"]) -> None:
    """Write the states of results as a table, and what measuring the older ones costs."""
    from hairpipe.graphs.experiments.figures.state import CURRENT

    rows = [("results", "state", "commit", "processor", "changed")]
    for state in states:
        more = len(state.changed) - NAMED
        changed = ", ".join(state.changed[:NAMED]) + (f" and {more} more" if more > 0 else "")
        costs = duration(state.results.processor)
        rows.append((shown(state.path), state.word, state.results.commit[:7], costs, changed))
    older = [state for state in states if state.word != CURRENT]
    cost = duration(sum(state.results.processor for state in older))
    click.echo(table(rows, "<<<><"))
    click.echo(f"{plural(len(states), 'results file')}, {len(states) - len(older)} current; the others cost {cost}")
    for command in dict.fromkeys(state.results.command for state in older):
        click.echo(f"  {command}")
