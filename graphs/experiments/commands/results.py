"""`hairpipe results`: which recorded figures are current."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hairpipe.app.api.formatting import duration, plural, shown, table
from hairpipe.app.cli import options

if TYPE_CHECKING:
    from hairpipe.graphs.experiments.figures.recipe import State

NAMED = 3
"""Number of changes that are named for each results file."""


@click.command()
@click.argument("paths", nargs=-1, metavar="[PATH]...", type=click.Path(path_type=Path))
@options.as_json
def results(paths: tuple[Path, ...], as_json: bool) -> None:
    """List recorded figures and whether they are current.

    The list names the code and nodes that have changed since, and the cost of a new measurement.

    PATH is a page, a graph, a results file, or a folder; the current folder without one. Results are current where
    code, settings and files are as they were when the results were recorded.

    Exit codes: 0 all results are current; 1 some are not current; 2 bad input.
    """
    from hairpipe.graphs.experiments.figures.pages import find_results
    from hairpipe.graphs.experiments.figures.recipe import CURRENT, state_of

    given = paths or (Path(),)
    states = [state_of(path) for path in find_results(given)]
    if as_json:
        click.echo(json.dumps({"results": [document(state) for state in states]}, indent=2))
    else:
        show(states)
    sys.exit(0 if all(state.word == CURRENT for state in states) else 1)


def document(state: "State") -> dict[str, object]:
    """Describe the state of results as a JSON document."""
    found = state.results
    return {
        "path": shown(state.path),
        "state": state.word,
        "changed": list(state.changed),
        "commit": found.commit,
        "command": found.command,
        "processor": found.processor,
    }


def show(states: list["State"]) -> None:
    """Write the states of results as a table, and what measuring the older ones costs."""
    from hairpipe.graphs.experiments.figures.recipe import CURRENT

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
