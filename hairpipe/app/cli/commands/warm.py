"""`hairpipe warm`: compile kernels ahead of the first run."""

import sys

import click

import hairpipe
from hairpipe.app.cli import options
from hairpipe.app.cli.stderr import echo
from hairpipe.errors import BadInput


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
