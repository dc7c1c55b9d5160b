"""`hairpipe tune`: find the cheapest model of hair that keeps a tolerance in a scene."""

import json
import os
import shlex
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

import hairpipe
from hairpipe.app.api.formatting import shown
from hairpipe.app.cli import options
from hairpipe.app.cli.completion import complete_node
from hairpipe.app.cli.stderr import echo
from hairpipe.errors import BadInput
from hairpipe.plain_file import check_plain

if TYPE_CHECKING:
    from hairpipe.app.api.reports import Event, Outcome
    from hairpipe.app.api.shot import Shot
    from hairpipe.app.tune.measured import Tolerance
    from hairpipe.app.tune.study import RunNodes

INTERRUPTED = 130


def read_tolerance(ctx: click.Context, param: click.Parameter, text: str) -> "Tolerance":
    from hairpipe.app.tune.measured import read_tolerance as read

    return read(text)


def read_time(ctx: click.Context, param: click.Parameter, text: str | None) -> float | None:
    from hairpipe.app.tune.measured import read_seconds

    return None if text is None else read_seconds(text, param.opts[0])


def read_output(ctx: click.Context, param: click.Parameter, path: Path | None) -> Path | None:
    """Read the output path, and raise BadInput for one that cannot be written, before hours of computation."""
    if path is None:
        return None
    check_plain(path, "the name of a file")
    path = path.resolve()
    if path.exists() and not path.is_file():
        raise BadInput("is not a file", where=path, right="the name of a file")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        what = "cannot be written to" if path.parent.is_dir() else "no such folder"
        raise BadInput(what, where=path.parent, right="-o FILE in a folder that can be written to")
    return path


@click.command()
@options.graph
@click.option("--node", required=True, metavar="NODE", shell_complete=complete_node, help="Node of the simulation.")
@click.option(
    "--tolerance",
    required=True,
    metavar="2mm|0.5%",
    callback=read_tolerance,
    help="Maximum error of tips and of whole strands: a length, or a percentage of the length of strands.",
)
@click.option(
    "--budget",
    metavar="5s",
    callback=read_time,
    help="Maximum processor time per frame; the smallest error within it is reported.",
)
@click.option(
    "--time",
    metavar="30min",
    callback=read_time,
    help="Processor time of all measurements after which the best model so far is chosen; by default a tenth of that "
    "of the shot's own simulation, ten minutes at least.",
)
@click.option(
    "--looks",
    is_flag=False,
    flag_value=1.0,
    type=click.FloatRange(1.0),
    metavar="[RATIO]",
    help="Maximum ratio (1 without a number) of differences in statistics of chaotic hair to those within the "
    "reference; if absent, differences are reported, and no model is refused for them.",
)
@click.option(
    "--check", is_flag=True, help="Measure choices on two other samples, too, and take none that fails there."
)
@click.option(
    "--also",
    multiple=True,
    metavar="GRAPH",
    help="Graph with another motion; prints whether the tolerance is kept there, too, as its roots move no harder.",
)
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), callback=read_output, help="TOML file to write the settings to."
)
@options.overrides
@options.side_by_side
@options.cache
@click.option("-q", "--quiet", is_flag=True, help="Print no progress of runs.")
@options.as_json
def tune(
    graph: str,
    node: str,
    tolerance: "Tolerance",
    budget: float | None,
    time: float | None,
    looks: float | None,
    check: bool,
    also: tuple[str, ...],
    output: Path | None,
    overrides: dict[str, str],
    engine: options.Engine,
    cache: Path,
    quiet: bool,
    as_json: bool,
) -> None:
    """Find the cheapest model that keeps a tolerance.

    Errors are those of tips or of whole strands, the larger, root mean square, against the graph's own model at a
    quarter of its steps; seconds are those of the processor on one thread, scaled to all strands. Where hair acts on
    hair, the reference is four members at half the steps that differ by a fifth of the tolerance: once two of them
    are half the tolerance apart, the means of members are compared. Other differences of what is seen of hair are
    reported, and with --looks refused. The
    chosen combination was measured itself, not predicted from its parts. All results are cached: the same command,
    given again, computes nothing. It holds for motions whose roots are no faster, and accelerate no more, than those of
    this shot.

    Independent simulations run side by side, on this machine or on the workers of a Dask cluster: references, members,
    and models before the measured frames. Measured frames of models run on this machine, one at a time, on one thread,
    so that their seconds are those of an idle machine.

    The settings are TOML tables that take the place of those in the graph. Exit codes: 0 found, 1 nothing keeps the
    tolerance, or a check is beyond it, 2 bad input, 130 interrupted.
    """
    from hairpipe.app.tune.report import changed_tables, comment, document, text_of, write_toml
    from hairpipe.app.tune.study import Interrupted, Request, simplified
    from hairpipe.app.tune.tuning import look_at
    from hairpipe.app.tune.tuning import tune as find
    from hairpipe.engine.store.atomic import write_text

    shot = hairpipe.load(graph, options.parsed(overrides), cache=cache)
    others = {other: hairpipe.load(other, cache=cache) for other in also}
    request = Request(shot, node, tolerance, runner(engine, quiet=quiet), budget, check, looks=looks, time=time)
    try:
        motions = {other: look_at(replace(request, shot=moved)).hardest for other, moved in others.items()}
        tuned = find(request, echo if not quiet else lambda line: None)
    except Interrupted:
        echo("hairpipe: interrupted; measurements are kept, and the same command resumes")
        sys.exit(INTERRUPTED)
    fragment = None
    if tuned.choice.parts is not None:
        words = ["hairpipe", "tune", graph, "--node", node, "--tolerance", str(tolerance).replace(" ", "")]
        command = shlex.join(words + [word for pair in overrides.items() for word in ("--set", "=".join(pair))])
        tables = changed_tables(shot.tables, simplified(shot.tables, node, tuned.choice.parts))
        fragment = write_toml(tables, comment(tuned, command))
    if as_json:
        click.echo(json.dumps(document(tuned, fragment, motions), indent=2))
    else:
        click.echo(text_of(tuned, motions))
        if fragment is not None and not output:
            click.echo(f"\n{fragment}", nl=False)
    if output and fragment is not None:  # last, so that the results are printed even if the disk is full
        write_text(output, fragment)
        click.echo(f"settings: {shown(output)}", err=as_json)
    sys.exit(0 if tuned.kept else 1)


def runner(engine: options.Engine, *, quiet: bool) -> "RunNodes":
    """Make a function that runs a shot and reports what is measured; a warning of many models is reported once.

    engine  of runs that are not timed
    """
    reported: set[str] = set()

    def run(text: str, shot: "Shot", nodes: Sequence[str], frames: Sequence[int], *, timed: bool = True) -> "Outcome":
        def report(event: "Event") -> None:
            mark = event.message if event.kind == "warning" else text
            if event.kind not in ("started", "warning") or mark in reported or (quiet and event.kind == "started"):
                return
            reported.add(mark)
            echo(f"warning: {text}: {mark}" if event.kind == "warning" else f"measuring: {text}")

        where = options.Engine(jobs=1, scans=1, scheduler=None, insecure=False) if timed else engine
        return shot.run(frames, to=nodes, keep_going=True, progress=report, **where).outcome

    return run
