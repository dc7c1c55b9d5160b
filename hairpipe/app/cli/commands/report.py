"""`hairpipe report`: the page of a graph as a folder, to send."""

from pathlib import Path

import click

import hairpipe
from hairpipe.app.api.formatting import shown, size
from hairpipe.app.cli import options


@click.command()
@options.graph
@options.frames
@options.overrides
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
@options.cache
def report(
    graph: str,
    frames: tuple[int, ...] | None,
    overrides: dict[str, str],
    wedge: str | None,
    output: Path,
    single: bool,
    megabytes: float,
    cache: Path,
) -> None:
    """Write the results of a graph as a page for any browser.

    It shows what is in the cache, as `hairpipe view` does: strands, meshes, level sets, pictures, tables, at every
    frame. Nothing is computed, and the page asks no server for anything.
    """
    from hairpipe.app.cli.run_display import Steps
    from hairpipe.app.page.report import write_report

    shot = hairpipe.load(graph, options.parsed(overrides), cache=cache)
    made = write_report(
        shot,
        output,
        frames,
        wedge=None if wedge is None else shot.wedge(wedge),
        most_bytes=1e6 * megabytes,
        single=single,
        progress=Steps("document"),
    )
    place = output if single else output / "index.html"
    click.echo(f"{shown(place)}  {size(made.size)}, at most {made.strands:,} strands of a groom")
