"""The page of a graph: served while the graph is edited and runs, or written as a folder to send."""

import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hairpipe.app.api.formatting import shown, size
from hairpipe.app.cli import options

if TYPE_CHECKING:
    from hairpipe.app.api.shot import Shot


@click.command()
@options.graph
@options.frames
@options.overrides
@options.wedge
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    metavar="N",
    help="Port of the server; by default any free port.",
)
@click.option("--no-browser", is_flag=True, help="Print the address without opening a browser.")
@click.option("--new", is_flag=True, help="Begin an empty graph, as for a missing file; the first save writes it.")
@options.cache
def view(
    graph: str,
    frames: tuple[int, ...] | None,
    overrides: dict[str, str],
    wedge: str | None,
    port: int,
    no_browser: bool,
    new: bool,
    cache: Path,
) -> None:
    """Show a graph and what it made in a browser.

    Strands, meshes, level sets, pictures and tables at every frame. The graph is edited there: nodes, wires, groups of
    settings and their values, with undo and redo. `plan` says what would run, runs begin and end, and what is saved
    changes only the edited lines of the graph file. Runs of other processes and machines are followed, from the cache
    alone.

    With --wedge the variants are shown next to each other, and a run computes all of them.

    The page is served to this machine alone, at an address with a secret in it. Ctrl-C ends it.
    """
    from hairpipe.app.api.draft import EMPTY, load_draft
    from hairpipe.app.cli.commands.environment import asking
    from hairpipe.app.page.report import opened
    from hairpipe.app.page.server import Server
    from hairpipe.app.page.session import Session

    is_new = new or (graph.endswith(".toml") and not Path(graph).exists())
    draft = asking(lambda: load_draft(graph, EMPTY if is_new else None, cache=cache))
    session = Session(draft, frames, wedge)
    for target, text in overrides.items():
        session.edit(target, text)
    server = Server(session, port)
    click.echo(f"{server.address}  (Ctrl-C ends it)")
    sys.stdout.flush()
    with nullcontext() if no_browser else opened(server.address):
        server.serve()


@click.command()
@options.shot
@options.frames
@options.wedge
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="Folder or file to write.")
@click.option("--single", is_flag=True, help="Write a single HTML file.")
@click.option(
    "--size",
    "megabytes",
    type=click.FloatRange(1.0, 10_000.0),
    default=60.0,
    show_default=True,
    metavar="MB",
    help="Maximum size of the report; it limits the number of strands shown.",
)
def report(
    shot: "Shot", frames: tuple[int, ...] | None, wedge: str | None, output: Path, single: bool, megabytes: float
) -> None:
    """Write the results of a graph as a page for any browser.

    It shows what is in the cache, as `hairpipe view` does: strands, meshes, level sets, pictures, tables, at every
    frame. Nothing is computed, and the page asks no server for anything.
    """
    from hairpipe.app.cli.run_display import Steps
    from hairpipe.app.page.report import write_report

    variants = None if wedge is None else shot.wedge(wedge)
    made = write_report(
        shot, output, frames, wedge=variants, most_bytes=1e6 * megabytes, single=single, progress=Steps("document")
    )
    place = output if single else output / "index.html"
    click.echo(f"{shown(place)}  {size(made.size)}, at most {made.strands:,} strands of a groom")
