"""Computation of a graph: run here, compiled ahead, or handed to a farm."""

import json
import sys
from pathlib import Path

import click

import hairpipe
from hairpipe.app.cli import options
from hairpipe.app.cli.stderr import echo
from hairpipe.errors import BadInput


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
        from hairpipe.graphs.experiments.figures.recording import Recording  # pyright: ignore[reportMissingImports]

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


@click.command()
@options.graphs
@options.jobs
@click.option("-q", "--quiet", is_flag=True, help="Print only warnings and failures.")
def warm(graphs: tuple[str, ...], jobs: int, quiet: bool) -> None:
    """Compile the kernels of graphs ahead of their first run.

    The first two frames of each GRAPH are computed in a temporary folder and discarded; no file is published. Nodes
    compile in parallel. By default these are the shipped shots whose data is present. Kernels that are compiled already
    are only loaded.

    Exit code 0: all is compiled, 1: a node failed.
    """
    from hairpipe.app.api.shot import shots_to_warm, warming
    from hairpipe.app.cli.commands.environment import asking
    from hairpipe.app.cli.run_display import RunDisplay, report_faults

    failed = False
    for name in graphs or shots_to_warm():
        try:
            shot = asking(lambda name=name: hairpipe.load(name))
        except BadInput as fault:
            if graphs:
                raise
            echo(f"{name} is omitted: {fault}")
            continue
        with warming(shot) as (warm_shot, frames), RunDisplay(warm_shot.graph, jobs, quiet=quiet) as display:
            done = warm_shot.run(frames, jobs=jobs, progress=display, keep_going=True)
        report_faults(done, verbose=False)
        failed = failed or not done.ok
        if not quiet:
            click.echo(f"{name}: kernels are compiled" if done.ok else f"{name}: not all kernels are compiled")
    sys.exit(failed)


@click.command()
@options.graph
@options.frames
@options.overrides
@options.wedge
@click.option("--chunk", type=click.IntRange(min=1), default=10, show_default=True, help="Number of frames of a task.")
@click.option(
    "--format",
    "form",
    type=click.Choice(["openjd", "commands"]),
    default="openjd",
    show_default=True,
    help="Format of the job: openjd (job.json, Open Job Description), commands (commands.txt, one a line).",
)
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), metavar="FOLDER", required=True, help="Folder for the job."
)
@options.cache
def farm(
    graph: str,
    frames: tuple[int, ...] | None,
    overrides: dict[str, str],
    wedge: str | None,
    chunk: int,
    form: str,
    output: Path,
    cache: Path,
) -> None:
    """Write the commands that compute a shot in parts, for a farm. Nothing is computed.

    The parts are values for the shot, frames that need no simulation, simulations (a task each), frames that need
    them, and files of all frames. Of a wedge, what the variants share comes first, then a task for each variant, or for
    its frames. The order saves time and changes no result: a task computes whatever it needs that
    is not in the cache, which all machines share. A task ends with exit code 0 where all that it was asked for is
    computed, and with 75 where another one still computes it: run it again.
    """
    from hairpipe.app.farm import FORMATS, build_steps
    from hairpipe.engine.store.atomic import write_text

    shot = hairpipe.load(graph, options.parsed(overrides), cache=cache)
    chosen = shot if wedge is None else shot.wedge(wedge)
    common = [word for name, value in overrides.items() for word in ("--set", f"{name}={value}")]
    common += [] if wedge is None else ["--wedge", wedge]
    steps = build_steps(chosen.levels(), chosen.graph.select(frames), chunk, common)
    name, write = FORMATS[form]
    path = Path(graph)
    text = write(steps, str(path.absolute()) if path.exists() else graph, cache.absolute())
    write_text(output / name, text)
    tasks = sum(map(len, steps))
    click.echo(f"{output / name}: {tasks} tasks in {len(steps)} steps")
