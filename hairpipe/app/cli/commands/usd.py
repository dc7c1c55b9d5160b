"""`hairpipe usd`: check USD files."""

import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hairpipe.app.cli import options
from hairpipe.engine.node.messages import one_line
from hairpipe.plain_file import check_plain

if TYPE_CHECKING:
    from hairpipe.formats.usd.check.finding import Finding


@click.group()
def usd() -> None:
    """Check USD files."""


@usd.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--for",
    "client",
    type=click.Choice(["unreal", "houdini", "blender"]),
    help="Program that reads the file, with rules of its own.",
)
@options.as_json
def check(file: Path, client: str | None, as_json: bool) -> None:
    """Check a shot and its OpenVDB files, more strictly than OpenUSD does.

    Each finding is a line: severity, rule, path @ time, fault. Exit code 0: no findings, 1: findings, 2: FILE cannot be
    read.
    """
    from hairpipe.apart import work_apart

    check_plain(file, "a USD file")
    findings = work_apart(lint_file, file, client)
    if as_json:
        click.echo(json.dumps({"file": str(file), "findings": [asdict(finding) for finding in findings]}, indent=2))
    else:
        for finding in findings:
            click.echo(one_line(str(finding)))
    sys.exit(1 if findings else 0)


def lint_file(file: Path, client: str | None = None) -> "list[Finding]":
    from hairpipe.formats.usd.check.lint import lint
    from hairpipe.formats.vdb_read import inspect

    return lint(file, inspect, client)
