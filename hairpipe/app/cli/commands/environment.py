"""What a run finds on this machine: trusted folders of nodes, third-party data, versions of software."""

import importlib.metadata
import json
import platform
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from hairpipe import __version__
from hairpipe.app.api.formatting import plural, table
from hairpipe.app.cli import options
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


@click.group()
def data() -> None:
    """Check third-party data that some graphs read."""


@data.command()
@options.as_json
def check(as_json: bool) -> None:
    """List the third-party files that shipped graphs and tests read: whether each is present, and its source.

    The variable HAIRPIPE_DATA names their folder; its default in a checkout is `shared/data` next to the checkout.
    Files are compared by SHA-256; nothing is downloaded.

    Exit code 0: all are present, 1: some are absent or differ, 2: the folder is not known.
    """
    from hairpipe.app.api.formatting import table
    from hairpipe.app.api.third_party import check_data

    folder, states = check_data()
    if as_json:
        files = [{"state": state, **source._asdict()} for source, state in states.items()]
        click.echo(json.dumps({"folder": str(folder), "files": files}, indent=2))
    else:
        rows = [("", "file", "repository on GitHub", "commit", "path in it", "licence")]
        rows += [(state, x.name, x.repository, x.commit, x.path, x.licence) for x, state in states.items()]
        click.echo(f"{folder}\n{table(rows, '<<<<<<')}")
    sys.exit(any(state != "present" for state in states.values()))


DISTRIBUTIONS = {
    "numpy": "numpy",
    "scipy": "scipy",
    "numba": "numba",
    "usd": "usd-core",
    "h5py": "h5py",
    "blosc": "blosc",
}


@click.command()
@options.as_json
def version(as_json: bool) -> None:
    """Print versions, cores, class of processor and threading layer."""
    from hairpipe.engine.worker.threading_layer import choose_layer, usable_cores
    from hairpipe.openvdb_library import version_of_openvdb
    from hairpipe.processor import processor_class

    found: dict[str, str | int | None] = {"hairpipe": __version__, "python": platform.python_version()}
    found |= {name: version_of(distribution) for name, distribution in DISTRIBUTIONS.items()}
    found |= {"openvdb": version_of_openvdb()}
    found |= {"threads": usable_cores(), "class": processor_class(), "threading layer": choose_layer().name}
    if as_json:
        click.echo(json.dumps(found, indent=2))
    else:
        click.echo(
            table([(name, "not installed" if value is None else str(value)) for name, value in found.items()], "<<")
        )


def version_of(distribution: str) -> str | None:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None
