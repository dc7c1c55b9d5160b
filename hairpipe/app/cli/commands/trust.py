"""`hairpipe trust`: trusted folders of nodes."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from hairpipe.app.api.formatting import plural, table
from hairpipe.app.cli.stderr import echo
from hairpipe.engine.node.messages import one_line
from hairpipe.errors import BadInput

if TYPE_CHECKING:
    from hairpipe.engine.file.trust import Trusted

Result = TypeVar("Result")


@click.command()
@click.argument("folder", required=False, type=click.Path(path_type=Path))
@click.option("--list", "as_list", is_flag=True, help="List the trusted folders.")
@click.option("--revoke", is_flag=True, help="Revoke the trust in FOLDER.")
def trust(folder: Path | None, as_list: bool, revoke: bool) -> None:
    """Trust the code in a folder of nodes.

    FOLDER is the folder `nodes` next to a graph file. It contains code, which is imported only if you trust its present
    content; after a change, it must be trusted again. Our own nodes and those of installed packages are trusted.

    Folders in the variable HAIRPIPE_TRUST are trusted with any content: for farms, and for authors of nodes.
    """
    from hairpipe.engine.file import trust as trusting

    if as_list:
        click.echo(table([(str(e.folder), plural(len(e.files), "file"), state(e)) for e in trusting.trusted()], "<><"))
        return
    if folder is None:
        raise click.UsageError("Missing argument 'FOLDER'.")
    if revoke:
        if not trusting.revoke(folder):
            raise BadInput("is not trusted", where=folder, right="one of hairpipe trust --list")
        click.echo(one_line(f"no longer trusted: {folder}"))
        return
    files = trusting.code_in(folder.resolve()) if folder.is_dir() else {}
    if folder.absolute().name != "nodes" or not files:
        raise BadInput("not a folder of node types", where=folder, right="the folder nodes next to a graph file")
    trusting.trust(folder, files)
    click.echo(one_line(f"trusted: {folder}: {', '.join(files)}"))


def state(entry: "Trusted") -> str:
    if not entry.folder.is_dir():
        return "is gone"
    return f"changed since: {', '.join(entry.changed)}" if entry.changed else "as it was"


def asking(load: Callable[[], Result]) -> Result:
    """Load a graph; on a terminal, ask for trust in its code. Raises Untrusted elsewhere, and if it is denied."""
    from hairpipe.engine.file.trust import Untrusted
    from hairpipe.engine.file.trust import trust as note

    try:
        return load()
    except Untrusted as doubt:
        if sys.stdin is None or not sys.stdin.isatty() or not sys.stderr.isatty():
            raise
        echo(f"{doubt.folder}: {doubt.what}")
        if not click.confirm("This code will run with your rights. Do you trust this code?", err=True):
            raise
        note(doubt.folder, doubt.files)
    return load()
