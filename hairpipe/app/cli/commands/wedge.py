"""`hairpipe wedge`: variants of a graph, compared in a table and in pictures."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

import hairpipe
from hairpipe.app.api.formatting import plural, shown
from hairpipe.app.cli import options
from hairpipe.app.cli.completion import complete_node, complete_variant
from hairpipe.errors import BadInput
from hairpipe.plain_file import check_plain

if TYPE_CHECKING:
    from hairpipe.app.api.shot import Shot


@click.group()
def wedge() -> None:
    """Compare the variants of a graph, and choose one.

    A wedge is a table [wedge.NAME] in a graph file; `hairpipe run GRAPH --wedge NAME` computes its variants.
    """


@wedge.command("list")
@options.graph
@options.overrides
@options.as_json
def ls(graph: str, overrides: dict[str, str], as_json: bool) -> None:
    """List the wedges of a graph, and their variants."""
    wedges = hairpipe.load(graph, options.parsed(overrides)).wedges
    if as_json:
        document = {name: {"axes": found.axes, "variants": found.variants} for name, found in wedges.items()}
        click.echo(json.dumps({"wedges": document}, indent=2))
    for name, found in {} if as_json else wedges.items():
        click.echo(f"{name}: {plural(len(found.variants), 'variant')} of {', '.join(found.axes)}")
        click.echo("".join(f"  {variant}\n" for variant in found.variants), nl=False)


@wedge.command()
@options.shot
@options.wedge_name
@options.frames
@options.as_markdown
@options.as_json
def table(shot: "Shot", name: str, frames: tuple[int, ...] | None, as_markdown: bool, as_json: bool) -> None:
    """Compare variants by their measures.

    Of a column with several rows there are the mean and the largest. Seconds of the processor, and size, are those of
    what not all variants share; what some share counts for each of them. Nothing is computed: what is not in the cache
    is empty.
    """
    from hairpipe.app.wedge import compare, document, markdown, text

    found = shot.wedge(name)
    rows = compare(found, frames)
    if as_json:
        click.echo(json.dumps(document(found, rows), indent=2))
    elif as_markdown:
        click.echo(markdown(rows))
    else:
        click.echo(text(rows))


@wedge.command()
@options.shot
@options.wedge_name
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="Path of the PNG file to write.")
@click.option("--frame", type=int, help="Frame of the pictures; by default the last of the shot.")
@click.option(
    "--node",
    metavar="NODE",
    shell_complete=complete_node,
    help="Node of the pictures; by default the first that the wedge shows.",
)
def sheet(shot: "Shot", name: str, output: Path, frame: int | None, node: str | None) -> None:
    """Write the pictures of all variants on one sheet.

    Each has its settings on it. Where axes are crossed, each column is a value of the last axis.
    """
    from hairpipe.app.wedge import write_sheet

    check_plain(output, "the name of a file")
    if output.is_dir():
        raise BadInput("is a folder", where=output, right="the name of a file")
    write_sheet(output, shot.wedge(name), frame, node)
    click.echo(shown(output))


@wedge.command()
@options.graph
@options.wedge_name
@click.argument("variant", shell_complete=complete_variant)
def promote(graph: str, name: str, variant: str) -> None:
    """Write the settings of a variant into the graph file; nothing else in it changes."""
    shot = hairpipe.load(graph)
    settings = shot.wedge(name).variant(variant).settings
    shot.save(settings)
    for target, value in settings.items():
        click.echo(f"{target} = {json.dumps(value, default=str)}")
