"""Other programs and their files: JSON lines, a shot in Blender, conversion to USD, and checks of USD files."""

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
    from hairpipe.formats.usd.check.scene import Finding


@click.command()
def bridge() -> None:
    """Serve another program by JSON lines on the standard streams.

    The program writes requests, such as {"id": 1, "do": "run", "graph": "shot.toml"}, and reads events: progress,
    frames, failures. The end of the input cancels a run and ends the command; computed results are kept. The reference
    of the protocol is in the documentation.
    """
    from hairpipe.app.bridge import main
    from hairpipe.child import die_with_parent

    die_with_parent()
    main()


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Blender file to save, .blend.")
@click.option("--picture", type=click.Path(path_type=Path), help="Picture of the first frame to render, .png or .webp.")
def blender(file: Path, output: Path | None, picture: Path | None) -> None:
    """Import a USD shot into Blender.

    Hair gets a material; body, level sets and frame range are those of the shot. With -o or --picture Blender runs in
    the background. Without, the script is printed, for Blender's text editor, or to start Blender with it.
    """
    from hairpipe.formats.blender import make_scene, script_of

    check_plain(file, "a USD file")
    if output is None and picture is None:
        click.echo(script_of(file), nl=False)
        return
    for path, suffixes in ((output, (".blend",)), (picture, (".png", ".webp"))):
        if path is not None:
            if path.suffix.lower() not in suffixes:
                raise click.UsageError(f"{path}: a file that ends in {' or '.join(suffixes)} is needed")
            check_plain(path, f"a {path.suffix} file")
            path.parent.mkdir(parents=True, exist_ok=True)
    make_scene(file, output, picture)
    for path in (output, picture):
        if path is not None:
            click.echo(path)


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("output", type=click.Path(path_type=Path))
def convert(file: Path, output: Path) -> None:
    """Write a file that Blender reads as USD.

    FILE is an FBX, Collada or Blender file, or any other that Blender reads; OUTPUT ends in .usd, .usda or .usdc.
    Meshes, skeletons, blend shapes and curves are written as they move, in all frames with keys; materials and lights
    are not. Blender runs in the background: the module bpy, or the program blender in the PATH. No script in a .blend
    file is run.
    """
    from hairpipe.formats.blender import convert

    check_plain(file, "a file that Blender reads")
    check_plain(output, "a USD file")
    convert(file, output)
    click.echo(output)


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
    from hairpipe.formats.vdb import inspect

    return lint(file, inspect, client)
