"""`hairpipe run`: compute what has changed, and publish it."""

import json
import sys
from pathlib import Path

import click

import hairpipe
from hairpipe.app.cli import options


@click.command()
@options.graph
@options.frames
@options.only
@options.overrides
@options.to
@options.wedge
@options.engine
@click.option("-k", "--keep-going", is_flag=True, help="Continue after a failure with independent nodes.")
@options.publish_root
@click.option("--force", is_flag=True, help="Overwrite files that are not from hairpipe or were changed.")
@click.option(
    "--wait",
    type=click.FloatRange(min=0.0),
    metavar="SECONDS",
    help="Longest wait for results that other processes compute, then exit code 75; by default without end.",
)
@click.option(
    "--report",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="Folder for a report of the run, as from `hairpipe report`.",
)
@click.option(
    "--record",
    is_flag=False,
    flag_value="",
    metavar="[NAME]",
    help="Write tables and costs to results/NAME.json next to the graph; by default NAME is GRAPH, or GRAPH_WEDGE.",
)
@options.cache
@click.option("-v", "--verbose", is_flag=True, help="Print the traceback of a failed node.")
@click.option("-q", "--quiet", is_flag=True, help="Print only warnings and failures.")
@options.as_json
def run(
    graph: str,
    frames: tuple[int, ...] | None,
    only: tuple[int, ...] | None,
    overrides: dict[str, str],
    to: tuple[str, ...],
    wedge: str | None,
    engine: options.Engine,
    keep_going: bool,
    publish_root: Path | None,
    force: bool,
    wait: float | None,
    report: Path | None,
    record: str | None,
    cache: Path,
    verbose: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Compute what has changed, and publish.

    GRAPH is a graph file, or the name of a graph that is shipped: `hairpipe run demo`. Files are published relative
    to the graph file; those of a shipped graph as if it lay in ./graphs. They stay below the folder of the project,
    which is the one that holds a folder `graphs` in which the file lies, else the file's own, or below --publish-root.

    With --wedge all variants of a wedge are computed, what they share once. What differs is published in a folder that
    is called after the variant.

    With --only a part of the frames is computed, each as in the shot of all --frames: a file or table of all frames is
    computed and published only by a run that finds all of them.

    A run that was stopped or killed resumes where it was. Exit codes: 0 all is computed, 1 a node failed, 2 bad input,
    75 other processes compute the rest, 130 interrupted.
    """
    from hairpipe.app.cli.commands.environment import asking
    from hairpipe.app.cli.run_display import RunDisplay, document, report_faults

    shot = asking(lambda: hairpipe.load(graph, options.parsed(overrides), cache=cache))
    shot = shot if wedge is None else shot.wedge(wedge)
    recording = None
    if record is not None:
        options.check_experiments("hairpipe run --record")
        from hairpipe.graphs.experiments.figures.recording import Recording

        recording = Recording(shot, record or None, overrides, frames, to)
    with RunDisplay(shot.graph, engine["jobs"], quiet=quiet) as display:
        done = shot.run(
            frames,
            to=to,
            progress=display,
            keep_going=keep_going,
            publish_root=publish_root,
            force=force,
            only=only,
            wait=wait,
            **engine,
        )
    if as_json:
        click.echo(json.dumps(document(done), indent=2))
    elif not quiet:
        click.echo(done.summary)
    if report is not None:
        from hairpipe.app.page.report import write_report

        plain = hairpipe.load(graph, options.parsed(overrides), cache=cache)
        write_report(plain, report, done.frames, wedge=None if wedge is None else plain.wedge(wedge), run=done)
    if recording is not None and done.ok:
        recording.write(done)
    report_faults(done, verbose)
    sys.exit(done.outcome.exit_code)
