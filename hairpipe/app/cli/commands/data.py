"""`hairpipe data`: third-party files that some graphs read and that are not shipped."""

import json
import sys

import click

from hairpipe.app.cli import options


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
