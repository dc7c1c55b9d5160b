"""`hairpipe validate`: errors of hair against theory and converged runs."""

import json
import math
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

import hairpipe
from hairpipe.app.api.formatting import duration, plural, shown, table
from hairpipe.app.cli import options
from hairpipe.errors import BadInput

if TYPE_CHECKING:
    from hairpipe.graphs.experiments.validation.validation import Measured

INTERRUPTED = 130


@click.command()
@options.graphs
@click.option("--quick", is_flag=True, help="Compute the rows of a short run only.")
@click.option("--others", is_flag=True, help="Show the recorded errors and costs of other solvers only.")
@click.option(
    "-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="HTML file for a page with pictures."
)
@click.option("--record", is_flag=True, help="Write the rows to results/NAME.json next to each graph.")
@options.side_by_side
@options.cache
@click.option("-q", "--quiet", is_flag=True, help="Print no progress.")
@options.as_json
def validate(
    graphs: tuple[str, ...],
    quick: bool,
    others: bool,
    output: Path | None,
    record: bool,
    engine: options.Engine,
    cache: Path,
    quiet: bool,
    as_json: bool,
) -> None:
    """Compare hair with theory and with converged runs.

    Every row is an error against an independent truth: a closed form, a boundary-value solution or a converged run.
    A row is promised or not; one that is not promised is shown with its error. Results are cached: a second run
    computes nothing.

    GRAPH is a validation; by default all that a clone has, in graphs/experiments. A node `rows` of its file collects
    tables of `check_errors`, a node `quick` those of a short run.

    Exit codes: 0 all promised rows are held, 1 some are missed or failed, 2 bad input, 130 interrupted.
    """
    from hairpipe.app.cli.run_display import RunDisplay, report_faults
    from hairpipe.engine.store.atomic import write_text
    from hairpipe.graphs.experiments.figures.recording import Recording
    from hairpipe.graphs.experiments.validation.validation import (
        collecting_node,
        measured_rows,
        picture_nodes,
        recorded_solvers,
        shipped_validations,
    )
    from hairpipe.graphs.experiments.validation.validation_page import written_page

    if others:
        solvers, source = recorded_solvers()
        click.echo(f"{table(solvers, '<<' + '>' * (len(solvers[0]) - 2))}\n\n{source}")
        return
    loaded = [hairpipe.load(graph, cache=cache) for graph in graphs or shipped_validations()]
    chosen = [(shot, node) for shot in loaded if (node := collecting_node(shot, quick=quick))]
    if not chosen:
        raise BadInput("no node 'quick'", where=", ".join(graphs), right="[quick], of the rows of a short run")
    suffix = "_quick" if quick else ""
    recordings = [Recording(shot, shot.path.stem + suffix, {}, None, [node]) for shot, node in chosen if record]
    rows = list["Measured"]()
    pictures = dict[str, bytes]()
    failed = False
    for place, (shot, node) in enumerate(chosen):
        drawn = picture_nodes(shot, node) if output else []
        with RunDisplay(shot.part((node, *drawn)), engine["jobs"], quiet=quiet) as display:
            done = shot.run(to=[node, *drawn], progress=display, keep_going=True, **engine)
        report_faults(done, verbose=False)
        if done.outcome.interrupted:
            sys.exit(INTERRUPTED)
        failed |= not done.ok
        rows += measured_rows(shot, node)
        if done.ok:
            titles = [shot.nodes[name].settings.get("title") or name for name in drawn]
            pictures |= {title: shot.get(name).path.read_bytes() for title, name in zip(titles, drawn, strict=True)}
            if record:
                recordings[place].write(done)
    total = conclusion(rows)
    if as_json:
        click.echo(json.dumps({"rows": [document(measured) for measured in rows]}, indent=2))
    else:
        show(rows, total)
    if output:
        write_text(output, written_page(rows, pictures, total, recorded_solvers() if not graphs else None))
        click.echo(f"page: {shown(output)}", err=as_json)
    sys.exit(1 if failed or any(measured.row.verdict == "missed" for measured in rows) else 0)


def conclusion(rows: Sequence["Measured"]) -> str:
    """Summarise the verdicts in a line."""
    found = Counter(measured.row.verdict for measured in rows)
    verdicts = ", ".join(f"{found[verdict]} {verdict}" for verdict in ("held", "missed", "not promised"))
    return f"{plural(len({measured.row.row for measured in rows}), 'row')}, {plural(len(rows), 'case')}: {verdicts}"


def document(measured: "Measured") -> dict[str, object]:
    """Describe a row as a JSON document; an error that is not a number is null."""
    row = measured.row
    found = row.measured if math.isfinite(row.measured) else None
    return row._asdict() | {"measured": found, "seconds": round(measured.seconds, 3)}


def show(rows: Sequence["Measured"], total: str) -> None:
    """Write the rows as a table, each with its cases below it."""
    from hairpipe.graphs.experiments.validation.validation_page import figure

    lines = [("row", "case", "measured", "allowed", "verdict", "processor")]
    for before, measured in zip([None, *rows], rows, strict=False):
        row = measured.row
        name = "" if before and row.row == before.row.row else row.row
        spent = duration(measured.seconds)
        lines.append((name, row.case, figure(row, row.measured), figure(row, row.allowed), row.verdict, spent))
    click.echo(f"{table(lines, '<<<<<>')}\n\n{total}")
