"""`hairpipe run`: compute what has changed, and publish it."""

import json
import sys
import time
from pathlib import Path

import click

from hairpipe.cli import options


@click.command()
@options.graph
@options.frames
@options.overrides
@options.to
@options.jobs
@click.option("-k", "--keep-going", is_flag=True, help="After a failure, go on with what does not depend on it.")
@options.publish_root
@click.option("--force", is_flag=True, help="Overwrite files that hairpipe has not published, or that were changed.")
@options.cache
@click.option("-v", "--verbose", is_flag=True, help="Show the traceback of a node that failed.")
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but warnings and failures.")
@options.as_json
def run(
    graph: str,
    frames: tuple[int, ...] | None,
    overrides: dict[str, str],
    to: tuple[str, ...],
    jobs: int,
    keep_going: bool,
    publish_root: Path | None,
    force: bool,
    cache: Path,
    verbose: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Compute what has changed, and publish.

    GRAPH is a graph file, or the name of a graph that is shipped: `hairpipe run demo`. Files are published relative
    to the graph file; those of a shipped graph as if it lay in ./graphs. They stay below the folder of the project,
    which is the one that holds a folder `graphs` in which the file lies, else the file's own, or below --publish-root.

    A run that was stopped or killed goes on where it was. Exit codes: 0 all is there, 1 a node failed, 2 bad input,
    130 interrupted.
    """
    from hairpipe.cli import summary
    from hairpipe.cli.commands.trust import asking
    from hairpipe.cli.shipped import open_graph
    from hairpipe.cli.watch import Watch
    from hairpipe.graph.run.scheduler import Options
    from hairpipe.graph.run.scheduler import run as carry_out
    from hairpipe.graph.store.store import Store

    opened, store = asking(lambda: open_graph(graph, overrides, to)), Store(cache)
    cache.mkdir(parents=True, exist_ok=True)
    how = Options(jobs=jobs, keep_going=keep_going, publish_root=publish_root, force=force)
    begun = time.monotonic()
    with Watch(opened, jobs, quiet=quiet) as watch:
        outcome = carry_out(opened, store, frames, how, watch)
    done = summary.Done(opened, store, opened.select(frames), outcome, watch, time.monotonic() - begun)
    if as_json:
        click.echo(json.dumps(summary.document(done), indent=2))
    elif not quiet:
        click.echo(summary.text(done))
    summary.say_faults(done, verbose)
    sys.exit(outcome.exit_code)
